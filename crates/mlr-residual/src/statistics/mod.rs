//! What a residual is like.

mod blocks;
mod chi_square;
mod noise;
mod runs;
mod spectrum;
mod whiteness;

pub(crate) use blocks::{BlockErrors, sign_flip_p_value};
pub(crate) use chi_square::chi_square_tail;
pub(crate) use noise::Noise;
pub(crate) use runs::runs_p_value;
pub(crate) use spectrum::dominant_frequency;
pub(crate) use whiteness::whiteness_p_value;

/// The middle value, or the mean of the two in the middle; NaN for no values.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => f64::NAN,
        count if count % 2 == 1 => values[middle],
        _ => 0.5 * (values[middle - 1] + values[middle]),
    }
}

/// Root of the mean square; 0 for no values.
pub(crate) fn rms(values: &[f64]) -> f64 {
    let sum: f64 = values.iter().map(|value| value * value).sum();
    (sum / values.len().max(1) as f64).sqrt()
}
