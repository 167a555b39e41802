//! What a residual is like.

mod blocks;
mod noise;
mod runs;
mod spectrum;
mod whiteness;

pub(crate) use blocks::{BlockErrors, sign_flip_p_value};
pub(crate) use noise::Noise;
pub(crate) use runs::runs_p_value;
pub(crate) use spectrum::dominant_frequency;
pub(crate) use whiteness::whiteness_p_value;

/// Root of the mean square; 0 for no values.
pub(crate) fn rms(values: &[f64]) -> f64 {
    let sum: f64 = values.iter().map(|value| value * value).sum();
    (sum / values.len().max(1) as f64).sqrt()
}
