use std::collections::BTreeMap;

use crate::{
    ErrorDeg, SensorModel, SensorRecord,
    fit::{Fit, least_squares},
    sensor_effects::{Inapplicable, LIBRARY, Parameter, SensorEffect},
    statistics::{BlockErrors, Noise, rms},
};

/// Blocks that each half is divided into.
const BLOCKS: usize = 15;

/// A set of effects, fitted on the first half and measured on both.
#[derive(Debug, Clone)]
pub(super) struct Trial {
    /// Effects in the order of the library with their parameters, which start at the
    /// values fitted.
    effects: Vec<(&'static dyn SensorEffect, Vec<Parameter>)>,
    /// Half widths of the 95 % intervals, parameter by parameter.
    half_width_95: Vec<f64>,
    /// Reference less model on the unseen half, degrees.
    pub(super) residual_deg: Vec<f64>,
    /// The same in blocks.
    pub(super) blocks: BlockErrors,
    fit_deg: f64,
    noise: Noise,
    half_s: f64,
}

impl Trial {
    /// Fits these effects from where their parameters start.
    pub(super) fn new(
        record: &SensorRecord,
        fit_half: &SensorRecord,
        mut effects: Vec<(&'static dyn SensorEffect, Vec<Parameter>)>,
    ) -> Self {
        let order = |kind: &str| LIBRARY.iter().position(|effect| effect.kind() == kind);
        effects.sort_by_key(|(effect, _)| order(effect.kind()));
        let parameters: Vec<Parameter> = effects
            .iter()
            .flat_map(|(_, parameters)| parameters.clone())
            .collect();
        let residual = |record: &SensorRecord, values: &[f64]| -> Vec<f64> {
            let mut rest = values;
            let chosen = effects.iter().map(|(effect, parameters)| {
                let (own, others) = rest.split_at(parameters.len());
                rest = others;
                (*effect, own.to_vec())
            });
            let model = SensorModel::new(chosen.collect());
            let reference = record.angle_deg();
            let start_deg = reference.first().copied().unwrap_or(0.0);
            let predicted = model.angle_deg(record.signals(), start_deg);
            reference
                .iter()
                .zip(predicted)
                .map(|(r, p)| r - p)
                .collect()
        };
        let Fit {
            values,
            half_width_95,
        } = least_squares(&parameters, BLOCKS, |values| residual(fit_half, values));
        let fit_error = residual(fit_half, &values);
        let residual_deg = residual(record, &values).split_off(record.half());
        let mut values = values.into_iter();
        for (parameter, value) in effects.iter_mut().flat_map(|(_, p)| p).zip(&mut values) {
            parameter.start = value;
        }
        Self {
            effects,
            half_width_95,
            blocks: BlockErrors::new(&residual_deg, BLOCKS),
            residual_deg,
            fit_deg: rms(&fit_error),
            noise: Noise::of(&fit_error, record.signals().period_s()),
            half_s: record.duration_s() / 2.0,
        }
    }

    /// Takes over another trial's reading of the noise where that is smaller.
    pub(super) fn lower_noise(&mut self, other: &Self) {
        self.noise = self.noise.least(other.noise);
    }

    /// The same with one more effect, fitted anew.
    pub(super) fn with(
        &self,
        record: &SensorRecord,
        fit_half: &SensorRecord,
        effect: &'static dyn SensorEffect,
    ) -> Result<Self, Inapplicable> {
        let mut effects = self.effects.clone();
        effects.push((effect, effect.parameters(fit_half)?));
        let mut trial = Self::new(record, fit_half, effects);
        trial.lower_noise(self);
        Ok(trial)
    }

    /// The same without an effect, fitted anew.
    pub(super) fn without(
        &self,
        record: &SensorRecord,
        fit_half: &SensorRecord,
        kind: &str,
    ) -> Self {
        let mut effects = self.effects.clone();
        effects.retain(|(effect, _)| effect.kind() != kind);
        let mut trial = Self::new(record, fit_half, effects);
        trial.lower_noise(self);
        trial
    }

    pub(super) fn has(&self, kind: &str) -> bool {
        self.effects.iter().any(|(effect, _)| effect.kind() == kind)
    }

    pub(super) fn parameter_count(&self) -> usize {
        self.half_width_95.len()
    }

    pub(super) fn error(&self) -> ErrorDeg {
        ErrorDeg {
            fit_deg: self.fit_deg,
            validation_deg: rms(&self.residual_deg),
            within_blocks_deg: self.blocks.within_deg(),
        }
    }

    /// Logarithm of the error on the unseen half, drift and what is within blocks
    /// counting alike.
    pub(super) fn score(&self) -> f64 {
        let error = self.error();
        error.validation_deg.ln() + error.within_blocks_deg.ln()
    }

    /// Error that noise alone would leave on the unseen half. Where an effect observes
    /// the drift, the random walk goes on for a second only.
    pub(super) fn noise_floor_deg(&self) -> f64 {
        let observed = self
            .effects
            .iter()
            .any(|(effect, _)| effect.observes_drift());
        let walk_s = if observed {
            1.0
        } else {
            // From one to two halves after the start, on average one and a half.
            1.5 * self.half_s
        };
        self.noise.floor_deg(walk_s)
    }

    pub(super) fn parameters_of(&self, kind: &str) -> BTreeMap<String, f64> {
        self.effects
            .iter()
            .filter(|(effect, _)| effect.kind() == kind)
            .flat_map(|(_, parameters)| parameters)
            .map(|parameter| (parameter.name.clone(), parameter.start))
            .collect()
    }

    /// Whether a parameter of this effect lies at a bound other than that at which the
    /// effect is absent.
    pub(super) fn is_at_bound(&self, kind: &str) -> bool {
        let of_kind = self
            .effects
            .iter()
            .filter(|(effect, _)| effect.kind() == kind);
        of_kind
            .flat_map(|(_, parameters)| parameters)
            .any(|parameter| {
                parameter.is_at_bound(parameter.start) && parameter.neutral != Some(parameter.start)
            })
    }

    /// Whether an effect may as well not be there, by the half that it was fitted on: the
    /// intervals of all that it has to set hold the value at which it does nothing.
    pub(super) fn is_absent(&self, kind: &str) -> bool {
        let mut parameters = self.parameters().filter(|(of, ..)| *of == kind).peekable();
        let holds = |(_, parameter, width): (&str, &Parameter, f64)| {
            let absent = parameter.neutral;
            absent.is_some_and(|absent| (parameter.start - absent).abs() <= width)
        };
        parameters.peek().is_some() && parameters.all(holds)
    }

    /// Every parameter with its effect's kind and the half width of its interval.
    pub(super) fn parameters(&self) -> impl Iterator<Item = (&'static str, &Parameter, f64)> {
        self.effects
            .iter()
            .flat_map(|(effect, parameters)| parameters.iter().map(|p| (effect.kind(), p)))
            .zip(&self.half_width_95)
            .map(|((kind, parameter), width)| (kind, parameter, *width))
    }
}
