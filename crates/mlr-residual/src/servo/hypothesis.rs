//! A set of effects of a servo, and the motion of the bench with them.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::{ServoModel, ServoRecording};
use crate::{EffectParameter, servo_effects::ServoEffect};

/// Change of a coordinate over which slopes are taken, in standard deviations of its prior: far above
/// what the simulation's single precision makes of an angle.
const SLOPE_STEP: f64 = 0.1;

/// Effects that a servo may have all of. Its coordinates are those of their parameters in a row, in
/// standard deviations from the means of their priors.
#[derive(Debug, Clone)]
pub(super) struct Hypothesis<'a> {
    described: &'a ServoModel,
    recordings: &'a [ServoRecording],
    pub(super) effects: Vec<&'static dyn ServoEffect>,
    parameters: Vec<EffectParameter>,
}

impl<'a> Hypothesis<'a> {
    pub(super) fn new(
        described: &'a ServoModel,
        recordings: &'a [ServoRecording],
        effects: Vec<&'static dyn ServoEffect>,
    ) -> Self {
        let parameters = effects
            .iter()
            .flat_map(|effect| effect.parameters(described))
            .collect();
        Self {
            described,
            recordings,
            effects,
            parameters,
        }
    }

    /// The servo without effects.
    pub(super) fn described(&self) -> &'a ServoModel {
        self.described
    }

    pub(super) fn recordings(&self) -> &'a [ServoRecording] {
        self.recordings
    }

    /// The same with one effect more.
    pub(super) fn with(&self, effect: &'static dyn ServoEffect) -> Self {
        let mut effects = self.effects.clone();
        effects.push(effect);
        Self::new(self.described, self.recordings, effects)
    }

    /// The same without one of the effects, and the coordinates of the others.
    pub(super) fn without(&self, left_out: usize, z: &DVector<f64>) -> (Self, DVector<f64>) {
        let mut effects = self.effects.clone();
        effects.remove(left_out);
        let ranges = self.ranges();
        let kept: Vec<f64> = ranges
            .iter()
            .enumerate()
            .filter(|(k, _)| *k != left_out)
            .flat_map(|(_, range)| z.as_slice()[range.clone()].to_vec())
            .collect();
        let smaller = Self::new(self.described, self.recordings, effects);
        (smaller, DVector::from_vec(kept))
    }

    pub(super) fn has(&self, kind: &str) -> bool {
        self.effects.iter().any(|effect| effect.kind() == kind)
    }

    pub(super) fn kinds(&self) -> Vec<&'static str> {
        self.effects.iter().map(|effect| effect.kind()).collect()
    }

    /// Which coordinates are those of each effect.
    pub(super) fn ranges(&self) -> Vec<std::ops::Range<usize>> {
        let mut next = 0;
        self.effects
            .iter()
            .map(|effect| {
                let from = next;
                next += effect.parameters(self.described).len();
                from..next
            })
            .collect()
    }

    pub(super) fn parameter(&self, k: usize) -> &EffectParameter {
        &self.parameters[k]
    }

    /// Coordinates moved inside the bounds.
    pub(super) fn within_bounds(&self, z: &DVector<f64>) -> DVector<f64> {
        DVector::from_fn(z.len(), |k, _| self.parameters[k].within_bounds(z[k]))
    }

    /// What makes the priors of bounded parameters integrate to one.
    pub(super) fn ln_truncation(&self) -> f64 {
        self.parameters
            .iter()
            .map(EffectParameter::ln_truncation)
            .sum()
    }

    /// The model with these coordinates.
    pub(super) fn model(&self, z: &DVector<f64>) -> ServoModel {
        let mut model = self.described.clone();
        for (effect, range) in self.effects.iter().zip(self.ranges()) {
            let values: Vec<f64> = range.map(|k| self.parameters[k].value(z[k])).collect();
            effect.apply(&values, &mut model);
        }
        model
    }

    /// Of each recording in a row: reported less predicted angle of every sample, rad, then the
    /// controller's effort where it is told. `None` where a simulation does not stay finite.
    pub(super) fn residual(&self, z: &DVector<f64>) -> Option<DVector<f64>> {
        let model = self.model(z);
        let each: Option<Vec<Vec<f64>>> = self
            .recordings
            .par_iter()
            .map(|recording| residual(&model, recording))
            .collect();
        Some(DVector::from_vec(each?.concat()))
    }

    /// Change of the prediction with each of these coordinates.
    pub(super) fn jacobian(
        &self,
        z: &DVector<f64>,
        residual: &DVector<f64>,
        coordinates: std::ops::Range<usize>,
    ) -> DMatrix<f64> {
        let slope = |k: usize| {
            let tried = |step: f64| {
                let mut moved = z.clone();
                moved[k] += step;
                let moved = self.within_bounds(&moved);
                let step = moved[k] - z[k];
                (step != 0.0).then_some((moved, step))
            };
            let (moved, step) = tried(SLOPE_STEP).or_else(|| tried(-SLOPE_STEP))?;
            Some((residual - self.residual(&moved)?) / step)
        };
        let columns: Vec<DVector<f64>> = coordinates
            .into_par_iter()
            .map(|k| slope(k).unwrap_or_else(|| DVector::zeros(residual.len())))
            .collect();
        if columns.is_empty() {
            return DMatrix::zeros(residual.len(), 0);
        }
        DMatrix::from_columns(&columns)
    }
}

/// Reported less predicted angle of every sample, rad, and effort where it is told.
fn residual(model: &ServoModel, recording: &ServoRecording) -> Option<Vec<f64>> {
    let predicted = model.predicted_rad(recording)?;
    let pairs = recording.positions_rad.iter().zip(predicted);
    let angles = pairs.map(|(reported, predicted)| reported - predicted);
    Some(angles.chain(model.effort_errors(recording)).collect())
}
