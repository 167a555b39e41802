//! The strongest oscillation in a residual.

use std::f64::consts::TAU;

use realfft::RealFftPlanner;

/// Frequency in Hz and amplitude in the signal's unit of its strongest oscillation,
/// after its straight-line trend is removed. A slow wander shows as a frequency of a
/// few cycles in the whole signal.
pub(crate) fn dominant_frequency(signal: &[f64], period_s: f64) -> Option<(f64, f64)> {
    let n = signal.len();
    if n < 16 || period_s <= 0.0 {
        return None;
    }
    let middle = (n - 1) as f64 / 2.0;
    let mean = signal.iter().sum::<f64>() / n as f64;
    let (mut covariance, mut variance) = (0.0, 0.0);
    for (i, value) in signal.iter().enumerate() {
        covariance += (i as f64 - middle) * (value - mean);
        variance += (i as f64 - middle).powi(2);
    }
    let slope = covariance / variance;
    // Hann's window: an oscillation between two bins keeps out of the others.
    let mut windowed: Vec<f64> = signal
        .iter()
        .enumerate()
        .map(|(i, value)| {
            let weight = 0.5 - 0.5 * (TAU * i as f64 / n as f64).cos();
            weight * (value - mean - slope * (i as f64 - middle))
        })
        .collect();
    let plan = RealFftPlanner::<f64>::new().plan_fft_forward(n);
    let mut bins = plan.make_output_vec();
    plan.process(&mut windowed, &mut bins).ok()?;
    let powers = bins.iter().map(|bin| bin.norm_sqr());
    let (k, power) = powers
        .enumerate()
        .skip(1)
        .max_by(|(_, a), (_, b)| a.total_cmp(b))?;
    // The window's mean is one half, and a real oscillation has two mirror bins.
    let amplitude = 4.0 * power.sqrt() / n as f64;
    Some((k as f64 / (n as f64 * period_s), amplitude))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_oscillation_is_found_on_a_trend() {
        let signal: Vec<f64> = (0..5000)
            .map(|i| f64::from(i) * 0.01)
            .map(|t| 3.0 + 0.2 * t + 0.7 * (TAU * 3.3 * t).sin())
            .collect();
        let (frequency, amplitude) = dominant_frequency(&signal, 0.01).unwrap();
        assert!((frequency - 3.3).abs() < 0.02, "{frequency}");
        assert!((amplitude - 0.7).abs() < 0.05, "{amplitude}");
    }
}
