//! Algorithm 2 of the paper: the FFT-based filter.

use std::sync::Arc;

use realfft::{ComplexToReal, RealFftPlanner, num_complex::Complex64};
use serde::{Deserialize, Serialize};

use crate::{Axes, Axis, EvenSamples, PowerSpectrum, SettingError, Spectrum, spectrum::Transform};

/// Parameters of the filter, with the paper's values as defaults.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct FilterSettings {
    /// F_c: higher frequencies are removed.
    pub cutoff_hz: f64,
    /// P_c: bins with less power are removed. One-sided mean-square power in
    /// deg², as [`PowerSpectrum`] defines it: 0.1 deg² is an oscillation of
    /// 0.45° amplitude.
    pub power_threshold_deg2: f64,
    /// Rate of the common time vector on which signals are reconstructed.
    pub rate_hz: f64,
}

impl Default for FilterSettings {
    fn default() -> Self {
        Self {
            cutoff_hz: 10.0,
            power_threshold_deg2: 0.1,
            rate_hz: 250.0,
        }
    }
}

impl FilterSettings {
    /// Checks every number. Zero is a threshold as well: everything below the cutoff
    /// survives.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        let check = SettingError::check::<f64>;
        check("cutoff_hz", self.cutoff_hz, 0.01..=1000.0, "Hz")?;
        let threshold_deg2 = self.power_threshold_deg2;
        check("power_threshold_deg2", threshold_deg2, 0.0..=1e6, "deg²")?;
        check("rate_hz", self.rate_hz, 0.1..=10_000.0, "Hz")?;
        if self.rate_hz <= 2.0 * self.cutoff_hz {
            let expected = format!("more than twice cutoff_hz, {} Hz", 2.0 * self.cutoff_hz);
            return Err(SettingError::new("rate_hz", self.rate_hz, expected));
        }
        Ok(())
    }
}

/// Roll, pitch and yaw after the filter, on the common time vector: sample q is
/// at `q / rate_hz` after the window's start.
pub type Conditioned = Axes<Vec<f64>>;

/// Which bins of one axis survive the filter, in increasing order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Selection(Vec<usize>);

impl Selection {
    /// Steps 2 to 5 of Algorithm 2 for roll and pitch, 2 and 6 to 8 for yaw.
    ///
    /// Bins above `last_bin` (the cutoff) count as having no power. Yaw keeps
    /// every bin whose power exceeds the threshold. Roll and pitch keep only
    /// those that are peaks as well: larger than both neighbours. The constant
    /// has one neighbour only and is never a peak, so roll and pitch lose their
    /// mean; a plateau of equal powers keeps its middle.
    pub fn of(axis: Axis, power: &PowerSpectrum, last_bin: usize, threshold_deg2: f64) -> Self {
        let below_cutoff = &power.deg2[..power.deg2.len().min(last_bin + 1)];
        Self(match axis {
            Axis::Yaw => (0..below_cutoff.len())
                .filter(|&k| below_cutoff[k] > threshold_deg2)
                .collect(),
            Axis::Roll | Axis::Pitch => peaks(below_cutoff)
                .into_iter()
                .filter(|&k| below_cutoff[k] > threshold_deg2)
                .collect(),
        })
    }

    /// The surviving bins.
    pub fn bins(&self) -> &[usize] {
        &self.0
    }
}

/// Local maxima away from bin 0, as SciPy's `find_peaks` finds them in the
/// powers followed by a zero.
fn peaks(power: &[f64]) -> Vec<usize> {
    let at = |k: usize| power.get(k).copied().unwrap_or(0.0);
    let mut found = Vec::new();
    let mut k = 1;
    while k < power.len() {
        let mut end = k;
        while end + 1 < power.len() && power[end + 1] == power[k] {
            end += 1;
        }
        if power[k - 1] < power[k] && at(end + 1) < power[k] {
            found.push(k.midpoint(end));
        }
        k = end + 1;
    }
    found
}

/// The filter for windows of one duration.
///
/// Spectra are taken at each signal's own rate; only bins up to the cutoff
/// survive, and these mean the same frequencies at every rate. The inverse
/// transform then evaluates them on the common time vector. Nothing is
/// resampled in between.
pub struct FourierFilter {
    settings: FilterSettings,
    duration_s: f64,
    planner: RealFftPlanner<f64>,
    forward: Option<Transform>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    half_spectrum: Vec<Complex64>,
    scratch: Vec<Complex64>,
}

impl FourierFilter {
    /// A filter for windows of `duration_s`.
    ///
    /// # Errors
    /// [`SettingError`] when a setting or the duration makes no sense.
    pub fn new(settings: FilterSettings, duration_s: f64) -> Result<Self, SettingError> {
        settings.check()?;
        SettingError::check("duration_s", duration_s, 0.01..=3600.0, "s")?;
        let mut planner = RealFftPlanner::new();
        let samples = (settings.rate_hz * duration_s).round().max(2.0) as usize;
        let inverse = planner.plan_fft_inverse(samples);
        Ok(Self {
            settings,
            duration_s,
            half_spectrum: inverse.make_input_vec(),
            scratch: inverse.make_scratch_vec(),
            inverse,
            forward: None,
            planner,
        })
    }

    /// Number of samples of the common time vector.
    pub fn samples(&self) -> usize {
        self.inverse.len()
    }

    /// Algorithm 2 on all three axes.
    pub fn condition(&mut self, window: &EvenSamples) -> Conditioned {
        window.angles_rad().as_ref().map(|axis, samples| {
            let spectrum = self.spectrum(samples);
            let selection = self.select(axis, &spectrum);
            self.reconstruct(&spectrum, &selection)
        })
    }

    /// Step 1: the spectrum of one signal that spans the window.
    pub fn spectrum(&mut self, samples: &[f64]) -> Spectrum {
        let transform = match self.forward.take() {
            Some(transform) if transform.samples() == samples.len() => transform,
            _ => Transform::new(&mut self.planner, samples.len()),
        };
        self.forward.insert(transform).spectrum(samples)
    }

    /// Steps 2 to 8: which bins of the axis survive.
    pub fn select(&self, axis: Axis, spectrum: &Spectrum) -> Selection {
        // A hair of tolerance keeps a bin exactly at the cutoff.
        let last_bin = (self.settings.cutoff_hz * self.duration_s + 1e-9).floor() as usize;
        Selection::of(
            axis,
            &spectrum.power(),
            last_bin,
            self.settings.power_threshold_deg2,
        )
    }

    /// Step 9: the inverse transform of the surviving bins on the common time
    /// vector (Eq. (ifft)). Linear in the spectrum for a given selection.
    pub fn reconstruct(&mut self, spectrum: &Spectrum, selection: &Selection) -> Vec<f64> {
        self.half_spectrum.fill(Complex64::ZERO);
        for &k in selection.bins() {
            if let (Some(slot), Some(bin)) = (self.half_spectrum.get_mut(k), spectrum.bins.get(k)) {
                *slot = bin / spectrum.samples as f64;
            }
        }
        // The constant is real; a bin at the very end of an even-length half
        // spectrum would have to be, and lies beyond any allowed cutoff.
        self.half_spectrum[0].im = 0.0;
        let mut signal = self.inverse.make_output_vec();
        self.inverse
            .process_with_scratch(&mut self.half_spectrum, &mut signal, &mut self.scratch)
            .expect("all buffers were made by the plan, and the constant is real");
        signal
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use proptest::prelude::*;

    use super::*;
    use crate::{OrientationSeries, SamplingLimits, Window};

    const DURATION_S: f64 = 5.0;

    fn filter() -> FourierFilter {
        FourierFilter::new(FilterSettings::default(), DURATION_S).unwrap()
    }

    fn sampled(rate_hz: f64, signal: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..(rate_hz * DURATION_S) as usize)
            .map(|i| signal(i as f64 / rate_hz))
            .collect()
    }

    fn filtered(axis: Axis, samples: &[f64]) -> Vec<f64> {
        let mut filter = filter();
        let spectrum = filter.spectrum(samples);
        let selection = filter.select(axis, &spectrum);
        filter.reconstruct(&spectrum, &selection)
    }

    #[test]
    fn exact_on_sinusoids_below_the_cutoff_whatever_the_rate() {
        let signal = |t: f64| 0.1 * (TAU * t).sin() + 0.05 * (TAU * 3.0 * t + 1.0).cos();
        let expected = sampled(250.0, signal);
        for rate_hz in [250.0, 970.0, 1000.0, 333.0] {
            for axis in [Axis::Roll, Axis::Pitch, Axis::Yaw] {
                for (got, want) in filtered(axis, &sampled(rate_hz, signal))
                    .iter()
                    .zip(&expected)
                {
                    assert!((got - want).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn cutoff_and_threshold_remove_what_they_should() {
        let kept_deg = 0.46_f64.to_radians();
        let dropped_deg = 0.44_f64.to_radians();
        let power_of = |signal: Vec<f64>| signal.iter().map(|x| x * x).sum::<f64>();
        for axis in [Axis::Roll, Axis::Yaw] {
            let sine = |hz: f64, a: f64| sampled(970.0, move |t| a * (TAU * hz * t).sin());
            assert!(power_of(filtered(axis, &sine(2.0, kept_deg))) > 1e-3);
            assert!(power_of(filtered(axis, &sine(2.0, dropped_deg))) < 1e-20);
            assert!(power_of(filtered(axis, &sine(10.0, kept_deg))) > 1e-3);
            assert!(power_of(filtered(axis, &sine(10.2, kept_deg))) < 1e-20);
        }
    }

    #[test]
    fn roll_keeps_peaks_only_yaw_keeps_everything_strong() {
        let power = PowerSpectrum {
            deg2: vec![5.0, 1.0, 3.0, 2.0, 0.05, 0.09, 0.01, 4.0],
        };
        let kept = |axis| Selection::of(axis, &power, 100, 0.1).bins().to_vec();
        assert_eq!(kept(Axis::Roll), [2, 7]);
        assert_eq!(kept(Axis::Pitch), [2, 7]);
        assert_eq!(kept(Axis::Yaw), [0, 1, 2, 3, 7]);
    }

    #[test]
    fn a_drift_survives_in_yaw_and_not_in_roll() {
        let drift = sampled(250.0, |t| 0.1 * t);
        assert!(filtered(Axis::Roll, &drift).iter().all(|x| x.abs() < 1e-12));
        let yaw = filtered(Axis::Yaw, &drift);
        assert!((yaw[625] - 0.25).abs() < 0.01, "{}", yaw[625]);
    }

    #[test]
    fn senseless_settings_are_named() {
        let error = |change: fn(&mut FilterSettings)| {
            let mut settings = FilterSettings::default();
            change(&mut settings);
            FourierFilter::new(settings, 5.0).err().unwrap().to_string()
        };
        assert!(error(|s| s.cutoff_hz = -1.0).contains("cutoff_hz"));
        assert!(error(|s| s.power_threshold_deg2 = f64::NAN).contains("power_threshold_deg2"));
        assert!(error(|s| s.rate_hz = 19.0).contains("rate_hz"));
    }

    proptest! {
        #[test]
        fn linear_for_a_given_selection(
            x in prop::collection::vec(-1.0..1.0_f64, 400),
            y in prop::collection::vec(-1.0..1.0_f64, 400),
            a in -3.0..3.0_f64,
            bins in prop::collection::btree_set(0_usize..50, 0..10),
        ) {
            let mut filter = filter();
            let selection = Selection(bins.into_iter().collect());
            let mut apply = |signal: &[f64]| {
                let spectrum = filter.spectrum(signal);
                filter.reconstruct(&spectrum, &selection)
            };
            let mixed: Vec<f64> = x.iter().zip(&y).map(|(x, y)| a * x + y).collect();
            let (fx, fy, fmixed) = (apply(&x), apply(&y), apply(&mixed));
            for ((fx, fy), fmixed) in fx.iter().zip(&fy).zip(&fmixed) {
                prop_assert!((a * fx + fy - fmixed).abs() < 1e-12);
            }
        }

        #[test]
        fn filtering_twice_is_filtering_once(
            amplitudes in prop::collection::vec(0.0..0.2_f64, 12),
            phases in prop::collection::vec(0.0..TAU, 12),
        ) {
            let signal = |t: f64| amplitudes.iter().zip(&phases).enumerate()
                .map(|(k, (a, p))| a * (TAU * (k as f64 + 0.5) * t + p).sin())
                .sum::<f64>();
            for axis in [Axis::Roll, Axis::Yaw] {
                let once = filtered(axis, &sampled(250.0, signal));
                let twice = filtered(axis, &once);
                for (a, b) in once.iter().zip(&twice) {
                    prop_assert!((a - b).abs() < 1e-12);
                }
            }
        }

        #[test]
        fn high_frequency_noise_leaves_no_trace(hz in 11.0..100.0_f64, amplitude in 0.0..0.01_f64) {
            let hz = (hz * DURATION_S).round() / DURATION_S;
            let motion = |t: f64| 0.1 * (TAU * t).sin();
            let clean = filtered(Axis::Roll, &sampled(970.0, motion));
            let noisy = filtered(Axis::Roll, &sampled(970.0, |t| motion(t) + amplitude * (TAU * hz * t).sin()));
            for (a, b) in clean.iter().zip(&noisy) {
                prop_assert!((a - b).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn conditions_all_axes_of_a_recording() {
        let times_s: Vec<f64> = (0..7000).map(|i| f64::from(i) / 970.0).collect();
        let roll = times_s.iter().map(|t| 0.1 * (TAU * t).sin()).collect();
        let pitch = times_s
            .iter()
            .map(|t| 0.3 + 0.05 * (TAU * 2.0 * t).sin())
            .collect();
        let yaw = times_s.iter().map(|t| 1.0 + 0.2 * t).collect();
        let recording = OrientationSeries::new(times_s, Axes { roll, pitch, yaw }).unwrap();
        let window = Window {
            start_s: 1.0,
            duration_s: DURATION_S,
        };
        let cut = window.cut(&recording, &SamplingLimits::default()).unwrap();
        let conditioned = filter().condition(&cut);
        assert_eq!(conditioned.roll.len(), 1250);
        let mean = conditioned.pitch.iter().sum::<f64>() / 1250.0;
        assert!(mean.abs() < 1e-9, "roll and pitch lose their mean: {mean}");
        assert!(
            (conditioned.yaw[625] - 0.5).abs() < 0.01,
            "yaw keeps its drift"
        );
    }
}
