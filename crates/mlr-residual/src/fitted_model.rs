//! Effects with fitted parameters.

use std::collections::BTreeMap;

use crate::{
    Parameter, SensorModel, SensorRecord, Stretches,
    fit::{Fit, least_squares},
    sensor_effects::{LIBRARY, SensorEffect},
};

/// Blocks that a stretch is divided into.
pub(crate) const BLOCKS: usize = 15;

/// An effect and its parameters.
pub(crate) type ChosenEffect = (&'static dyn SensorEffect, Vec<Parameter>);

/// A set of effects, fitted on a record.
#[derive(Debug, Clone, Default)]
pub(crate) struct FittedModel {
    /// In the order of the library; each parameter starts at the value fitted.
    effects: Vec<ChosenEffect>,
    /// Half widths of the 95 % intervals, parameter by parameter.
    half_width_95: Vec<f64>,
}

impl FittedModel {
    /// Fits these effects from where their parameters start.
    pub(crate) fn new(record: &SensorRecord, mut effects: Vec<ChosenEffect>) -> Self {
        let order = |kind: &str| LIBRARY.iter().position(|effect| effect.kind() == kind);
        effects.sort_by_key(|(effect, _)| order(effect.kind()));
        let parameters: Vec<Parameter> = effects
            .iter()
            .flat_map(|(_, parameters)| parameters.clone())
            .collect();
        let Fit {
            values,
            half_width_95,
        } = least_squares(&parameters, BLOCKS, |values| {
            residual_deg(record, &effects, values)
        });
        for (parameter, value) in effects.iter_mut().flat_map(|(_, p)| p).zip(values) {
            parameter.start = value;
        }
        Self {
            effects,
            half_width_95,
        }
    }

    /// The same effects fitted on another record, from the values found. What an effect reads
    /// off the record before the fit is read off anew.
    pub(crate) fn refitted(&self, record: &SensorRecord) -> Self {
        let effects = self.effects.iter().map(|(effect, found)| {
            let read = effect.parameters(record).unwrap_or_else(|_| found.clone());
            let started = read.into_iter().zip(found).map(|(mut parameter, found)| {
                if !parameter.is_fixed() {
                    parameter.start = found.start;
                }
                parameter
            });
            (*effect, started.collect())
        });
        Self::new(record, effects.collect())
    }

    /// Reference less model over the scored samples of a record, degrees.
    pub(crate) fn residual_deg(&self, record: &SensorRecord) -> Vec<f64> {
        let parameters = self.effects.iter().flat_map(|(_, parameters)| parameters);
        let values: Vec<f64> = parameters.map(|parameter| parameter.start).collect();
        residual_deg(record, &self.effects, &values)
    }

    /// The effects, in the order of the library.
    pub(crate) fn effects(&self) -> &[ChosenEffect] {
        &self.effects
    }

    pub(crate) fn has(&self, kind: &str) -> bool {
        self.effects.iter().any(|(effect, _)| effect.kind() == kind)
    }

    pub(crate) fn parameter_count(&self) -> usize {
        self.half_width_95.len()
    }

    /// How long the random walk of the angle has gone on in a stretch, on average, s. Where an
    /// effect observes the drift, it is corrected after about a second.
    pub(crate) fn random_walk_s(&self, stretches: &Stretches, [from_s, to_s]: [f64; 2]) -> f64 {
        let mut effects = self.effects.iter();
        if effects.any(|(effect, _)| effect.observes_drift()) {
            1.0
        } else {
            0.5 * (from_s + to_s) - stretches.fit[0]
        }
    }

    pub(crate) fn parameters_of(&self, kind: &str) -> BTreeMap<String, f64> {
        self.parameters()
            .filter(|(of, ..)| *of == kind)
            .map(|(_, parameter, _)| (parameter.name.clone(), parameter.start))
            .collect()
    }

    /// Whether a parameter of this effect lies at a bound other than that at which the
    /// effect is absent.
    pub(crate) fn is_at_bound(&self, kind: &str) -> bool {
        self.parameters()
            .filter(|(of, ..)| *of == kind)
            .any(|(_, parameter, _)| {
                parameter.is_at_bound(parameter.start) && parameter.neutral != Some(parameter.start)
            })
    }

    /// Whether the 95 % intervals of all that an effect has to set hold the value at which it
    /// is absent.
    pub(crate) fn is_absent(&self, kind: &str) -> bool {
        let mut parameters = self.parameters().filter(|(of, ..)| *of == kind).peekable();
        let holds = |(_, parameter, width): (&str, &Parameter, f64)| {
            let absent = parameter.neutral;
            absent.is_some_and(|absent| (parameter.start - absent).abs() <= width)
        };
        parameters.peek().is_some() && parameters.all(holds)
    }

    /// Every parameter with its effect's kind and the half width of its interval.
    pub(crate) fn parameters(&self) -> impl Iterator<Item = (&'static str, &Parameter, f64)> {
        self.effects
            .iter()
            .flat_map(|(effect, parameters)| parameters.iter().map(|p| (effect.kind(), p)))
            .zip(&self.half_width_95)
            .map(|((kind, parameter), width)| (kind, parameter, *width))
    }
}

/// Reference less the model with these values of all parameters in a row, over the scored
/// samples, degrees.
fn residual_deg(record: &SensorRecord, effects: &[ChosenEffect], values: &[f64]) -> Vec<f64> {
    let mut values = values.iter().copied();
    let chosen = effects.iter().map(|(effect, parameters)| {
        let own = values.by_ref().take(parameters.len()).collect();
        (*effect, own)
    });
    let model = SensorModel::new(chosen.collect());
    let start_deg = record.angle_deg().first().copied().unwrap_or(0.0);
    record.error_deg(&model.angle_deg(record.signals(), start_deg))
}
