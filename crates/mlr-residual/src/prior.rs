//! What is known of a parameter before a record is seen.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use libm::{erf, erfc};

/// Distance from the mean, in standard deviations, beyond which the asymptotic series of Mills'
/// ratio is used: its error there is below 15 / 25⁶ = 6·10⁻⁸.
const FAR_TAIL: f64 = 25.0;

/// A normalised prior of one parameter, in the parameter's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Prior {
    /// A normal distribution.
    Normal {
        /// Mean, and most probable value.
        mean: f64,
        /// Standard deviation, positive. With any other, no value is possible.
        deviation: f64,
    },
}

impl Prior {
    /// Natural logarithm of the density at a value, over the whole real line.
    pub fn ln_density(&self, value: f64) -> f64 {
        self.ln_density_within(value, f64::NEG_INFINITY, f64::INFINITY)
    }

    /// Natural logarithm of the density at a value, normalised over the bounds. Values outside
    /// them are impossible: negative infinity.
    pub fn ln_density_within(&self, value: f64, lower: f64, upper: f64) -> f64 {
        let Self::Normal { mean, deviation } = *self;
        let possible = deviation > 0.0 && deviation.is_finite() && mean.is_finite();
        if !possible || lower >= upper || !(lower..=upper).contains(&value) {
            return f64::NEG_INFINITY;
        }
        let standardised = |x: f64| (x - mean) / deviation;
        let z = standardised(value);
        ln_truncated_normal(z, standardised(lower), standardised(upper)) - deviation.ln()
    }

    /// Natural logarithm of the probability of a value between these bounds: negative infinity
    /// where there is none.
    pub fn ln_mass_within(&self, lower: f64, upper: f64) -> f64 {
        let Self::Normal { mean, .. } = *self;
        let inside = mean.max(lower).min(upper);
        let within = self.ln_density_within(inside, lower, upper);
        if within == f64::NEG_INFINITY {
            return within;
        }
        self.ln_density(inside) - within
    }
}

/// Log density at `z` of the standard normal distribution between two bounds `a < b`.
fn ln_truncated_normal(z: f64, a: f64, b: f64) -> f64 {
    if b < 0.0 {
        return ln_truncated_normal(-z, -b, -a);
    }
    if a <= 0.0 {
        let mass = 0.5 * (erf(b * FRAC_1_SQRT_2) - erf(a * FRAC_1_SQRT_2));
        return -0.5 * z * z - 0.5 * TAU.ln() - mass.ln();
    }
    // In the tail, density and mass are taken relative to the density at the near bound, so that
    // neither underflows.
    let beyond_b = if b.is_finite() {
        mills_ratio(b) * (-0.5 * (b - a) * (b + a)).exp()
    } else {
        0.0
    };
    -0.5 * (z - a) * (z + a) - (mills_ratio(a) - beyond_b).ln()
}

/// Upper tail of the standard normal distribution over its density at the same place, `x ≥ 0`.
fn mills_ratio(x: f64) -> f64 {
    if x > FAR_TAIL {
        let square = x * x;
        return (1.0 - 1.0 / square + 3.0 / (square * square)) / x;
    }
    0.5 * TAU.sqrt() * (0.5 * x * x).exp() * erfc(x * FRAC_1_SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Simpson's rule over the density.
    fn integral(prior: Prior, bounds: [f64; 2], from: f64, to: f64) -> f64 {
        let intervals = 20_000;
        let width = (to - from) / f64::from(intervals);
        let weight = |i: i32| match i {
            _ if i == 0 || i == intervals => 1.0,
            _ if i % 2 == 1 => 4.0,
            _ => 2.0,
        };
        let density = |i: i32| {
            let value = (from + f64::from(i) * width).clamp(from, to);
            prior.ln_density_within(value, bounds[0], bounds[1]).exp()
        };
        (0..=intervals).map(|i| weight(i) * density(i)).sum::<f64>() * width / 3.0
    }

    const PRIOR: Prior = Prior::Normal {
        mean: 0.7,
        deviation: 0.2,
    };

    #[test]
    fn the_density_integrates_to_one_over_its_bounds() {
        for [lower, upper] in [
            [f64::NEG_INFINITY, f64::INFINITY],
            [0.5, 0.8],
            [0.7, f64::INFINITY],
            [f64::NEG_INFINITY, 0.4],
            [2.0, 3.0],
            [-9.0, -6.0],
            [0.699, 0.7005],
        ] {
            let (from, to) = (f64::max(lower, -10.0), f64::min(upper, 10.0));
            let total = integral(PRIOR, [lower, upper], from, to);
            assert!((total - 1.0).abs() < 1e-6, "[{lower}, {upper}]: {total}");
        }
        // Control: without normalisation, half the mass is lost at a bound on the mean.
        let unbounded = [f64::NEG_INFINITY, f64::INFINITY];
        let half = integral(PRIOR, unbounded, 0.7, 10.0);
        assert!((half - 0.5).abs() < 1e-6, "{half}");
    }

    #[test]
    fn the_mass_between_bounds_is_the_integral_of_the_density() {
        let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
        for [lower, upper] in [[0.5, 0.8], [0.7, 10.0], [-10.0, 0.4], [1.0, 1.5]] {
            let mass = PRIOR.ln_mass_within(lower, upper).exp();
            let expected = integral(PRIOR, everywhere, lower, upper);
            assert!((mass - expected).abs() < 1e-9, "[{lower}, {upper}]: {mass}");
        }
        assert_eq!(PRIOR.ln_mass_within(everywhere[0], everywhere[1]), 0.0);
        assert_eq!(PRIOR.ln_mass_within(0.8, 0.5), f64::NEG_INFINITY);
        // 40 deviations out, where the mass itself underflows.
        let far = PRIOR.ln_mass_within(8.7, f64::INFINITY);
        assert!((far + 804.608).abs() < 1e-3, "{far}");
    }

    #[test]
    fn the_maximum_is_at_the_mean_or_at_the_bound_next_to_it() {
        let mode = |lower: f64, upper: f64| {
            let values = (0..=1000).map(|i| f64::from(i) * 0.002);
            let density = |value: &f64| PRIOR.ln_density_within(*value, lower, upper);
            let best = values.max_by(|a, b| density(a).total_cmp(&density(b)));
            best.unwrap_or_default()
        };
        assert!((mode(f64::NEG_INFINITY, f64::INFINITY) - 0.7).abs() < 1e-12);
        assert!((mode(0.0, 1.0) - 0.7).abs() < 1e-12);
        assert!((mode(0.9, 2.0) - 0.9).abs() < 1e-12);
        assert!((mode(0.0, 0.5) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn no_value_outside_the_bounds_or_of_no_distribution_is_possible() {
        assert_eq!(PRIOR.ln_density_within(0.9, 0.0, 0.8), f64::NEG_INFINITY);
        assert_eq!(PRIOR.ln_density(f64::NAN), f64::NEG_INFINITY);
        for deviation in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let none = Prior::Normal {
                mean: 0.0,
                deviation,
            };
            assert_eq!(none.ln_density(0.0), f64::NEG_INFINITY, "{deviation}");
        }
        let peak = -(0.2 * TAU.sqrt()).ln();
        assert!((PRIOR.ln_density(0.7) - peak).abs() < 1e-12);
    }

    #[test]
    fn both_forms_of_the_tail_agree_where_they_meet() {
        let (near, far) = (mills_ratio(FAR_TAIL), mills_ratio(FAR_TAIL + 1e-9));
        assert!((near / far - 1.0).abs() < 1e-6, "{near} {far}");
    }
}
