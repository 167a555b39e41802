use std::sync::Arc;

use realfft::{RealFftPlanner, RealToComplex, num_complex::Complex64};

/// The frequencies of a signal up to a cutoff.
#[derive(Clone)]
pub struct Band {
    plan: Arc<dyn RealToComplex<f64>>,
    rate_hz: f64,
    bins: usize,
}
impl std::fmt::Debug for Band {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result { f.debug_struct("Band").finish() }
}

impl Band {
    pub fn new(samples: usize, rate_hz: f64, cutoff_hz: f64) -> Self {
        let last = (cutoff_hz * samples as f64 / rate_hz + 1e-9).floor() as usize;
        Self { plan: RealFftPlanner::new().plan_fft_forward(samples), rate_hz, bins: last.min(samples.saturating_sub(1) / 2) }
    }
    pub fn len(&self) -> usize { self.bins }
    pub fn frequencies_hz(&self) -> Vec<f64> {
        (1..=self.bins).map(|k| k as f64 * self.rate_hz / self.plan.len() as f64).collect()
    }
    /// Bins 1.. scaled: squares sum to mean square.
    pub fn spectrum(&self, signal: &[f64]) -> Vec<Complex64> {
        let mut input = signal.to_vec();
        let mut out = self.plan.make_output_vec();
        self.plan.process(&mut input, &mut out).expect("sized");
        let scale = 2.0_f64.sqrt() / signal.len() as f64;
        out.iter().skip(1).take(self.bins).map(|x| x * scale).collect()
    }
}
