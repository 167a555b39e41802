//! Discrete Fourier spectra and their power.

use std::sync::Arc;

use realfft::{RealFftPlanner, RealToComplex, num_complex::Complex64};

/// Non-redundant half of the discrete Fourier transform of a real signal,
/// `Y_k = Σ x_j e^{-2πi jk/n}` for `k = 0 … n/2` (Eq. (fft) of the paper).
#[derive(Debug, Clone)]
pub struct Spectrum {
    pub(crate) bins: Vec<Complex64>,
    pub(crate) samples: usize,
}

impl Spectrum {
    /// Mean-square power of each bin; see [`PowerSpectrum`].
    pub fn power(&self) -> PowerSpectrum {
        let n = self.samples as f64;
        let radians_to_degrees_sq = 1.0_f64.to_degrees().powi(2);
        let power = self.bins.iter().enumerate().map(|(k, bin)| {
            // Every bin but the constant and, for even n, the last one stands
            // for its mirror image as well.
            let sides = if k == 0 || 2 * k == self.samples {
                1.0
            } else {
                2.0
            };
            sides * bin.norm_sqr() / (n * n) * radians_to_degrees_sq
        });
        PowerSpectrum {
            deg2: power.collect(),
        }
    }
}

/// One-sided power spectrum in deg²: the mean square of what each bin
/// contributes to the signal.
///
/// A sine of amplitude A degrees whose frequency falls on a bin has the power
/// A²/2 there, a constant c has c² in bin 0, and the sum over all bins is the
/// signal's mean square (Parseval). The paper's threshold `P_c = 0.1` thus cuts
/// off oscillations below 0.45° of amplitude. This is SciPy's
/// `periodogram(x_deg, window="boxcar", detrend=False, scaling="spectrum")`.
#[derive(Debug, Clone, PartialEq)]
pub struct PowerSpectrum {
    /// Power of bin k, at frequency `k / duration`.
    pub deg2: Vec<f64>,
}

/// Transforms signals of one length.
pub(crate) struct Transform {
    plan: Arc<dyn RealToComplex<f64>>,
    input: Vec<f64>,
    scratch: Vec<Complex64>,
}

impl Transform {
    pub(crate) fn new(planner: &mut RealFftPlanner<f64>, samples: usize) -> Self {
        let plan = planner.plan_fft_forward(samples);
        Self {
            input: plan.make_input_vec(),
            scratch: plan.make_scratch_vec(),
            plan,
        }
    }

    pub(crate) fn samples(&self) -> usize {
        self.input.len()
    }

    /// `signal` must have the transform's length.
    pub(crate) fn spectrum(&mut self, signal: &[f64]) -> Spectrum {
        self.input.copy_from_slice(signal);
        let mut bins = self.plan.make_output_vec();
        self.plan
            .process_with_scratch(&mut self.input, &mut bins, &mut self.scratch)
            .expect("all buffers were made by the plan");
        Spectrum {
            bins,
            samples: signal.len(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use proptest::prelude::*;

    use super::*;

    fn power_of(signal: &[f64]) -> Vec<f64> {
        Transform::new(&mut RealFftPlanner::new(), signal.len())
            .spectrum(signal)
            .power()
            .deg2
    }

    #[test]
    fn a_sine_has_half_its_squared_amplitude_in_one_bin() {
        let amplitude_deg = 3.0_f64;
        for n in [500, 501] {
            let signal: Vec<f64> = (0..n)
                .map(|i| {
                    amplitude_deg.to_radians() * (TAU * 7.0 * f64::from(i) / f64::from(n)).sin()
                })
                .collect();
            let power = power_of(&signal);
            assert!((power[7] - 4.5).abs() < 1e-10);
            let elsewhere: f64 = power.iter().sum::<f64>() - power[7];
            assert!(elsewhere.abs() < 1e-10);
        }
    }

    proptest! {
        #[test]
        fn power_sums_to_the_mean_square(signal in prop::collection::vec(-1.0..1.0_f64, 2..200)) {
            let mean_square = signal.iter().map(|x| x.to_degrees().powi(2)).sum::<f64>()
                / signal.len() as f64;
            let total: f64 = power_of(&signal).iter().sum();
            prop_assert!((total - mean_square).abs() <= 1e-9 * mean_square.max(1.0));
        }
    }
}
