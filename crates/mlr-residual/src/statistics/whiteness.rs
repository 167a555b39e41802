//! Whether a residual is white.

/// Lags of the test. An even number: the distribution then has a closed form.
const LAGS: usize = 20;

/// The probability that white noise has autocorrelations as large as the signal's at
/// the first 20 lags (Ljung and Box, 1978).
pub(crate) fn whiteness_p_value(signal: &[f64]) -> f64 {
    let n = signal.len();
    if n <= 2 * LAGS {
        return 1.0;
    }
    let mean = signal.iter().sum::<f64>() / n as f64;
    let covariance = |lag: usize| -> f64 {
        let pairs = signal[lag..].iter().zip(signal);
        pairs.map(|(a, b)| (a - mean) * (b - mean)).sum()
    };
    let variance = covariance(0);
    if variance <= 0.0 {
        return 1.0;
    }
    let sum: f64 = (1..=LAGS)
        .map(|lag| (covariance(lag) / variance).powi(2) / (n - lag) as f64)
        .sum();
    upper_tail((n * (n + 2)) as f64 * sum)
}

/// Probability that χ² with [`LAGS`] degrees of freedom exceeds a value.
fn upper_tail(chi2: f64) -> f64 {
    let half = chi2 / 2.0;
    let mut term = 1.0;
    let mut sum = 1.0;
    for k in 1..LAGS / 2 {
        term *= half / k as f64;
        sum += term;
    }
    let probability = (-half).exp() * sum;
    if probability.is_finite() {
        probability
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt as _, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn the_distribution_is_that_of_the_tables() {
        assert!((upper_tail(31.410) - 0.05).abs() < 1e-4);
        assert!((upper_tail(10.851) - 0.95).abs() < 1e-4);
        assert_eq!(upper_tail(1e6), 0.0);
    }

    #[test]
    fn noise_is_white_and_its_integral_is_not() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let noise: Vec<f64> = (0..4000).map(|_| random.random::<f64>()).collect();
        assert!(whiteness_p_value(&noise) > 0.01);
        let mut sum = 0.0;
        let walk: Vec<f64> = noise
            .iter()
            .map(|x| {
                sum += x - 0.5;
                sum
            })
            .collect();
        assert!(whiteness_p_value(&walk) < 1e-6);
    }
}
