//! Whether errors are independent of their neighbours.

use libm::erfc;

/// The probability that independent errors form as few or as many runs above and below
/// their mean (Wald and Wolfowitz, 1940; normal approximation, two-sided).
pub(crate) fn runs_p_value(signal: &[f64]) -> f64 {
    let mean = signal.iter().sum::<f64>() / signal.len().max(1) as f64;
    let above: Vec<bool> = signal.iter().map(|value| *value > mean).collect();
    let ones = above.iter().filter(|is_above| **is_above).count() as f64;
    let (n, others) = (above.len() as f64, above.len() as f64 - ones);
    if ones == 0.0 || others == 0.0 || n < 3.0 {
        return 1.0;
    }
    let runs = 1.0 + above.windows(2).filter(|pair| pair[0] != pair[1]).count() as f64;
    let expected = 2.0 * ones * others / n + 1.0;
    let variance = (expected - 1.0) * (expected - 2.0) / (n - 1.0);
    erfc((runs - expected).abs() / (2.0 * variance).sqrt())
}

#[cfg(test)]
mod tests {
    use rand::{RngExt as _, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn noise_is_independent_and_a_wave_is_not() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let noise: Vec<f64> = (0..2000).map(|_| random.random::<f64>()).collect();
        assert!(runs_p_value(&noise) > 0.01);
        let wave: Vec<f64> = (0..2000).map(|i| (f64::from(i) * 0.1).sin()).collect();
        assert!(runs_p_value(&wave) < 1e-6);
        let alternating: Vec<f64> = (0..200).map(|i| f64::from(i % 2)).collect();
        assert!(runs_p_value(&alternating) < 1e-6);
        assert_eq!(runs_p_value(&[1.0; 10]), 1.0);
    }
}
