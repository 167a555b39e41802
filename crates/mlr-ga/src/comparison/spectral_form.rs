use mlr_filter::Band;

use super::ComparableWalk;

/// How angles are compared by their spectra.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpectralSettings {
    /// F_c: higher frequencies are removed, as by Algorithm 2.
    pub cutoff_hz: f64,
    /// Period of the gait, whose harmonics count in full.
    pub gait_period_s: f64,
    /// What the square of an error between two harmonics counts.
    pub between_harmonics: f64,
}

/// The spectrum in which angles of one length are compared: without mean and trend, up to the
/// cutoff, the frequencies between the harmonics of the gait weighed down.
///
/// What damage changes of a walk repeats with the gait; rubble, sensor noise and slip do not.
#[derive(Debug, Clone)]
pub(super) struct SpectralForm {
    samples: usize,
    trend: Trend,
    band: Band,
    /// Square root of what the square of each bin counts.
    weights: Vec<f32>,
}

impl SpectralForm {
    /// The form for so many `samples` of [`ComparableWalk::RATE_HZ`].
    pub(super) fn new(samples: usize, settings: SpectralSettings) -> Self {
        let band = Band::new(samples, ComparableWalk::RATE_HZ, settings.cutoff_hz);
        // Half the distance of two bins: every harmonic has the bin that is nearest to it.
        let reach_hz = 0.5 * ComparableWalk::RATE_HZ / samples.max(1) as f64;
        let is_harmonic = |frequency_hz: f64| {
            let order = (frequency_hz * settings.gait_period_s).round();
            order >= 1.0 && (frequency_hz - order / settings.gait_period_s).abs() <= reach_hz
        };
        let weight = |frequency_hz| match is_harmonic(frequency_hz) {
            true => 1.0,
            false => settings.between_harmonics.sqrt() as f32,
        };
        Self {
            samples,
            trend: Trend::new(samples),
            weights: band.frequencies_hz().map(weight).collect(),
            band,
        }
    }

    /// Samples of a signal.
    pub(super) fn samples(&self) -> usize {
        self.samples
    }

    /// Numbers that an axis has in this form: two for each bin.
    pub(super) fn axis_len(&self) -> usize {
        2 * self.band.len()
    }

    /// Takes mean and trend from `signal`, and writes the weighted bins to `spectrum`.
    pub(super) fn transform(&self, signal: &mut [f32], spectrum: &mut [f32]) {
        self.trend.remove(signal);
        let signal: Vec<f64> = signal.iter().copied().map(f64::from).collect();
        let bins = self.band.bins(&signal);
        for ((bin, weight), pair) in bins.iter().zip(&self.weights).zip(spectrum.chunks_mut(2)) {
            pair.copy_from_slice(&[bin.re as f32 * weight, bin.im as f32 * weight]);
        }
    }

    /// The mean square of the difference of two signals, given in this form, with every bin in
    /// full.
    pub(super) fn plain_square(&self, a: &[f32], b: &[f32]) -> f64 {
        let pairs = a.chunks(2).zip(b.chunks(2)).zip(&self.weights);
        pairs
            .map(|((a, b), weight)| {
                let square: f32 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
                f64::from(square / (weight * weight))
            })
            .sum()
    }
}

/// Removes mean and linear trend: projection on what is orthogonal to both.
#[derive(Debug, Clone)]
struct Trend {
    /// A line through zero in the middle, of unit length.
    slope: Vec<f32>,
}

impl Trend {
    fn new(samples: usize) -> Self {
        let middle = samples.saturating_sub(1) as f64 / 2.0;
        let line: Vec<f64> = (0..samples).map(|index| index as f64 - middle).collect();
        let length = line.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-12);
        Self {
            slope: line.iter().map(|x| (x / length) as f32).collect(),
        }
    }

    fn remove(&self, signal: &mut [f32]) {
        let mean = signal.iter().sum::<f32>() / signal.len() as f32;
        let along: f32 = signal
            .iter()
            .zip(&self.slope)
            .map(|(x, slope)| (x - mean) * slope)
            .sum();
        for (x, slope) in signal.iter_mut().zip(&self.slope) {
            *x -= mean + along * slope;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const SAMPLES: usize = 125;

    fn form() -> SpectralForm {
        let settings = SpectralSettings {
            cutoff_hz: 10.0,
            gait_period_s: 1.0,
            between_harmonics: 0.25,
        };
        SpectralForm::new(SAMPLES, settings)
    }

    /// Weighted and plain mean square of a signal of time in seconds.
    fn squares(signal: impl Fn(f64) -> f64) -> (f64, f64) {
        let form = form();
        let times_s = (0..SAMPLES).map(|i| i as f64 / ComparableWalk::RATE_HZ);
        let mut signal: Vec<f32> = times_s.map(|t| signal(t) as f32).collect();
        let mut spectrum = vec![0.0; form.axis_len()];
        form.transform(&mut signal, &mut spectrum);
        let weighted = spectrum.iter().map(|x| f64::from(x * x)).sum();
        (
            weighted,
            form.plain_square(&spectrum, &vec![0.0; form.axis_len()]),
        )
    }

    #[test]
    fn mean_and_trend_do_not_count_and_harmonics_count_in_full() {
        // A line through a sine turns it a little, as its trend is not zero.
        let near = |a: f64, b: f64| (a - b).abs() < 0.05;
        let (weighted, plain) = squares(|t| 5.0 - 0.3 * t);
        assert!(weighted < 1e-6 && plain < 1e-6, "{weighted} {plain}");
        let (weighted, plain) = squares(|t| 2.0 * (TAU * 3.0 * t).cos() + t);
        assert!(
            near(weighted, 2.0) && near(plain, 2.0),
            "{weighted} {plain}"
        );
        let (weighted, plain) = squares(|t| 2.0 * (TAU * 2.4 * t).cos());
        assert!(
            near(weighted, 0.5) && near(plain, 2.0),
            "{weighted} {plain}"
        );
        let (weighted, plain) = squares(|t| 2.0 * (TAU * 11.0 * t).cos());
        assert!(
            near(weighted, 0.0) && near(plain, 0.0),
            "{weighted} {plain}"
        );
    }

    #[test]
    fn every_harmonic_has_a_bin_whatever_the_length() {
        for samples in [60, 88, 113, 125] {
            let settings = SpectralSettings {
                cutoff_hz: 10.0,
                gait_period_s: 1.1,
                between_harmonics: 0.0,
            };
            let form = SpectralForm::new(samples, settings);
            let full = form.weights.iter().filter(|weight| **weight == 1.0);
            // Up to 10 Hz; the bin nearest to the last one may lie beyond the cutoff.
            assert!((10..=11).contains(&full.count()), "{samples}");
        }
    }
}
