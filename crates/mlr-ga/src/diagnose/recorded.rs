//! What a record of a simulated motion says of others.

use mlr_filter::OrientationSeries;

use crate::{
    IdentifySettings,
    belief::ErrorModel,
    comparison::{
        AlignedMeasurement, Alignment, ComparableWalk, LikelihoodSettings, SpectralSettings,
    },
};

/// A motion as a log of it would be compared with the model by `identify`.
pub(super) struct Recorded<'s> {
    measured: AlignedMeasurement,
    motion_deg2: [f64; 3],
    likelihood: LikelihoodSettings,
    /// What the model lacks of any real robot, as measured on the plant's.
    usual: &'s ErrorModel,
}

impl<'s> Recorded<'s> {
    /// Of the first `duration_s` of a motion with this period.
    pub(super) fn new(
        motion: &OrientationSeries,
        duration_s: f64,
        gait_period_s: f64,
        settings: &'s IdentifySettings,
    ) -> Self {
        let samples = (duration_s * ComparableWalk::RATE_HZ) as usize;
        let spectral = SpectralSettings {
            cutoff_hz: settings.filter.cutoff_hz,
            gait_period_s,
            between_harmonics: 1.0,
        };
        let measured = AlignedMeasurement::new(motion, 0.0, samples, spectral);
        Self {
            motion_deg2: measured.motion_deg2(Alignment::default()),
            measured,
            likelihood: settings.likelihood.of_samples(samples),
            usual: &settings.plausibility.usual,
        }
    }

    /// Logarithm of the likelihood of a model that moves like this, up to a constant.
    pub(super) fn ln_likelihood(&self, model: &ComparableWalk) -> f64 {
        let Some(mut misfit) = self.measured.misfit(model, 0, &self.likelihood) else {
            return f64::NEG_INFINITY;
        };
        let squares = misfit.mean_square_deg2.iter_mut().zip(self.motion_deg2);
        let usual = self.usual.noise_deg.iter().zip(&self.usual.motion_share);
        for ((square_deg2, motion_deg2), (noise_deg, share)) in squares.zip(usual) {
            *square_deg2 += noise_deg.powi(2) + share * share * motion_deg2;
        }
        self.likelihood.ln_likelihood(&misfit)
    }
}
