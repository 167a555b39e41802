use crate::{
    SensorRecord, Stretches,
    fitted_model::{BLOCKS, ChosenEffect, FittedModel},
    sensor_effects::{Inapplicable, SensorEffect},
    statistics::{BlockErrors, Noise, rms},
};

/// All that the selection sees of a record: it ends before the test stretch.
#[derive(Debug)]
pub(super) struct SelectionRecord {
    /// Fit and selection stretch.
    pub(super) whole: SensorRecord,
    /// The fit stretch alone.
    pub(super) fit: SensorRecord,
    stretches: Stretches,
}

impl SelectionRecord {
    pub(super) fn of(record: &SensorRecord) -> Self {
        Self {
            whole: record.before_test(),
            fit: record.fit_stretch(),
            stretches: record.stretches(),
        }
    }
}

/// A set of effects, fitted on the fit stretch and measured on the selection stretch.
#[derive(Debug, Clone)]
pub(super) struct Trial {
    pub(super) model: FittedModel,
    /// Squared errors on the selection stretch in blocks.
    pub(super) blocks: BlockErrors,
    pub(super) fit_deg: f64,
    pub(super) selection_deg: f64,
    noise: Noise,
    /// How long the random walk has gone on in the selection stretch.
    walk_s: f64,
}

impl Trial {
    /// Fits these effects from where their parameters start.
    pub(super) fn new(seen: &SelectionRecord, effects: Vec<ChosenEffect>) -> Self {
        let model = FittedModel::new(&seen.fit, effects);
        // The noise is read off what the fit left, by a model that saw no later sample.
        let fit_error_deg = model.residual_deg(&seen.fit);
        let noise = Noise::of(&fit_error_deg, seen.fit.signals().period_s());
        let error_deg = model.residual_deg(&seen.whole);
        let [_, selection_error_deg, _] = seen.stretches.divide(&seen.whole, &error_deg);
        Self {
            blocks: BlockErrors::new(selection_error_deg, BLOCKS),
            fit_deg: rms(&fit_error_deg),
            selection_deg: rms(selection_error_deg),
            walk_s: model.random_walk_s(&seen.stretches, seen.stretches.selection),
            model,
            noise,
        }
    }

    /// Takes over another trial's reading of the noise where that is smaller.
    pub(super) fn lower_noise(&mut self, other: &Self) {
        self.noise = self.noise.least(other.noise);
    }

    /// The same with one more effect, fitted anew.
    pub(super) fn with(
        &self,
        seen: &SelectionRecord,
        effect: &'static dyn SensorEffect,
    ) -> Result<Self, Inapplicable> {
        let mut effects = self.model.effects().to_vec();
        effects.push((effect, effect.parameters(&seen.fit)?));
        let mut trial = Self::new(seen, effects);
        trial.lower_noise(self);
        Ok(trial)
    }

    /// The same without an effect, fitted anew.
    pub(super) fn without(&self, seen: &SelectionRecord, kind: &str) -> Self {
        let mut effects = self.model.effects().to_vec();
        effects.retain(|(effect, _)| effect.kind() != kind);
        let mut trial = Self::new(seen, effects);
        trial.lower_noise(self);
        trial
    }

    /// Error that noise alone would leave on the selection stretch, degrees.
    pub(super) fn noise_floor_deg(&self) -> f64 {
        self.noise.floor_deg(self.walk_s)
    }

    /// Logarithm of the error on the selection stretch, drift and what is within blocks
    /// counting alike.
    pub(super) fn score(&self) -> f64 {
        self.selection_deg.ln() + self.blocks.within_deg().ln()
    }
}
