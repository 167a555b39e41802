//! Numbers drawn by a seeded generator.

use rand::{Rng, RngExt as _};

/// A number with a standard normal distribution (Box and Muller 1958).
pub fn standard_normal(generator: &mut impl Rng) -> f64 {
    let (radius, angle): (f64, f64) = (generator.random(), generator.random());
    let radius = libm::sqrt(-2.0 * libm::log(1.0 - radius));
    radius * libm::cos(std::f64::consts::TAU * angle)
}
