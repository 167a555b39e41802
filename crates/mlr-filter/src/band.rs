use std::{f64::consts::SQRT_2, fmt, sync::Arc};

use realfft::{RealFftPlanner, RealToComplex, num_complex::Complex64};

/// The frequencies of a signal up to a cutoff, without its mean: steps 1 and 2 of Algorithm 2,
/// for signals of one length and rate.
///
/// ```
/// use mlr_filter::Band;
/// use std::f64::consts::TAU;
///
/// // 5 s at 25 Hz up to 10 Hz; a sine of amplitude 3 at 2 Hz, and one beyond the cutoff.
/// let band = Band::new(125, 25.0, 10.0);
/// let signal: Vec<f64> = (0..125)
///     .map(|i| f64::from(i) / 25.0)
///     .map(|t| 3.0 * (TAU * 2.0 * t).sin() + (TAU * 11.0 * t).sin())
///     .collect();
/// let bins = band.bins(&signal);
/// let mean_square: f64 = bins.iter().map(|bin| bin.norm_sqr()).sum();
/// assert!((mean_square - 4.5).abs() < 1e-9);
/// let strongest = band.frequencies_hz().zip(&bins).find(|(_, bin)| bin.norm() > 1.0);
/// assert_eq!(strongest.unwrap().0, 2.0);
/// ```
#[derive(Clone)]
pub struct Band {
    plan: Arc<dyn RealToComplex<f64>>,
    rate_hz: f64,
    bins: usize,
}

impl Band {
    /// The band of signals of so many `samples`. Half of their rate bounds it as well.
    pub fn new(samples: usize, rate_hz: f64, cutoff_hz: f64) -> Self {
        // A hair of tolerance keeps a bin exactly at the cutoff.
        let last_bin = (cutoff_hz * samples as f64 / rate_hz + 1e-9).floor() as usize;
        Self {
            plan: RealFftPlanner::new().plan_fft_forward(samples.max(1)),
            rate_hz,
            bins: last_bin.min(samples.saturating_sub(1) / 2),
        }
    }

    /// Number of bins, the constant left out.
    pub fn len(&self) -> usize {
        self.bins
    }

    /// Whether no frequency is left.
    pub fn is_empty(&self) -> bool {
        self.bins == 0
    }

    /// Frequency of each bin.
    pub fn frequencies_hz(&self) -> impl Iterator<Item = f64> {
        let step_hz = self.rate_hz / self.plan.len() as f64;
        (1..=self.bins).map(move |bin| bin as f64 * step_hz)
    }

    /// The bins of a signal, scaled so that the sum of their squares is the mean square of the
    /// signal's part within the band. A signal of another length is cut, or followed by zeros.
    pub fn bins(&self, signal: &[f64]) -> Vec<Complex64> {
        let mut input = self.plan.make_input_vec();
        for (slot, x) in input.iter_mut().zip(signal) {
            *slot = *x;
        }
        let mut output = self.plan.make_output_vec();
        self.plan
            .process(&mut input, &mut output)
            .expect("all buffers were made by the plan");
        let scale = SQRT_2 / self.plan.len() as f64;
        let bins = output.iter().skip(1).take(self.bins);
        bins.map(|bin| bin * scale).collect()
    }
}

impl fmt::Debug for Band {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Band")
            .field("samples", &self.plan.len())
            .field("rate_hz", &self.rate_hz)
            .field("bins", &self.bins)
            .finish()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn bins_of_the_whole_band_sum_to_the_mean_square_without_the_mean(
            signal in prop::collection::vec(-1.0..1.0_f64, 1..100_usize),
        ) {
            // An odd length has no bin at half of the rate.
            let signal = match signal.len() % 2 {
                0 => &signal[1..],
                _ => &signal[..],
            };
            let n = signal.len() as f64;
            let mean = signal.iter().sum::<f64>() / n;
            let mean_square = signal.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
            let bins = Band::new(signal.len(), 25.0, 25.0).bins(signal);
            let total: f64 = bins.iter().map(Complex64::norm_sqr).sum();
            prop_assert!((total - mean_square).abs() < 1e-12);
        }

        #[test]
        fn no_length_and_no_cutoff_is_too_small(samples in 0_usize..5, cutoff_hz in 0.0..30.0_f64) {
            let band = Band::new(samples, 25.0, cutoff_hz);
            prop_assert_eq!(band.bins(&[1.0, 2.0]).len(), band.len());
            prop_assert_eq!(band.frequencies_hz().count(), band.len());
        }
    }
}
