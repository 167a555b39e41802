//! A model with effects, fitted to a record.

use std::convert::Infallible;

use mlr_filter::{Axes, OrientationSeries};
use mlr_model::Morphology;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::{Comparison, Effort, Poll, Prediction, Settled, Trace, WalkModel, WalkRecord};
use crate::{
    Parameter,
    walk_effects::{Place, WalkEffect},
};

/// An effect at a place, with the values of its parameters.
#[derive(Debug, Clone)]
pub(crate) struct Placed {
    pub(crate) effect: &'static dyn WalkEffect,
    pub(crate) place: Place,
    pub(crate) values: Vec<f64>,
}

/// What walks: a model and what is left of its robot.
#[derive(Debug, Clone)]
pub(crate) struct Walker<'a> {
    pub(crate) model: &'a WalkModel,
    pub(crate) morphology: &'a Morphology,
    /// How it walks over the whole record with the effects found, where that is known: a
    /// further effect that is on the sensor only changes nothing of it.
    pub(crate) body: Option<&'a OrientationSeries>,
}

/// Effects as they fit best, and what they leave.
#[derive(Debug, Clone)]
pub(crate) struct Trial {
    pub(crate) effects: Vec<Placed>,
    /// Cost on the fitted stretch, with prior.
    pub(crate) cost: f64,
    /// Mean square of each axis on the fitted stretch.
    pub(crate) fit_deg2: [f64; 3],
    /// The same on the unseen one.
    pub(crate) unseen_deg2: [f64; 3],
    /// Measured less predicted over the whole record.
    pub(crate) residual_deg: Axes<Vec<f64>>,
    /// Half the width of the 95 % interval of each value of each effect.
    pub(crate) half_width_95: Vec<Vec<f64>>,
    /// Sizes of the usual differences, in standard deviations.
    pub(crate) usual: Vec<f64>,
}

/// Steps after which a fit that has not settled is taken as it is.
const MAX_STEPS: usize = 6;
/// Shares of a step that are tried until one helps.
const STEP_SHARES: [f64; 3] = [1.0, 0.4, 0.15];
/// A step goes by ten of the parameters' own steps without a second thought (Levenberg).
const DAMPING: f64 = 0.01;
/// Gain of a step below which a fit has settled.
const SETTLED: f64 = 0.1;
/// How a rough fit is searched, distances in steps of the parameters.
const POLL: Poll = Poll {
    widest: 8.0,
    narrowest: 1.0,
    least_gain: SETTLED,
    most: 10,
};
/// 95 % quantile, two-sided, of a normal distribution.
const NORMAL_95: f64 = 1.96;

impl Placed {
    /// Whether it is the same effect at the same place, whatever its values.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        self.effect.kind() == other.effect.kind() && self.place == other.place
    }

    fn parameters(&self, model: &WalkModel) -> Vec<Parameter> {
        self.effect.parameters(self.place, model)
    }

    /// Whether it is no more than what robots of one make differ by.
    pub(crate) fn is_usual(&self, model: &WalkModel) -> bool {
        let parameters = self.parameters(model).into_iter();
        parameters
            .zip(&self.values)
            .all(|(parameter, value)| parameter.is_usual(*value))
    }
}

impl Walker<'_> {
    /// The model with these effects added one after the other.
    pub(crate) fn with(&self, effects: &[Placed]) -> WalkModel {
        let mut model = self.model.clone();
        for placed in effects {
            placed
                .effect
                .apply(placed.place, &placed.values, &mut model);
        }
        model
    }

    /// How the body walks; `None` when the walk diverges or a value makes no sense.
    fn body_of(
        &self,
        model: &WalkModel,
        record: &WalkRecord,
        samples: usize,
    ) -> Option<OrientationSeries> {
        let walked = model.walk(self.morphology, record, samples);
        walked.ok().flatten()
    }

    /// What a sensor reports of the first `samples` samples, and its rates at rest;
    /// `None` when the walk diverges or a value makes no sense.
    fn predict(
        &self,
        comparison: &Comparison<'_>,
        effects: &[Placed],
        samples: usize,
    ) -> Option<Prediction> {
        let model = self.with(effects);
        let record = comparison.record;
        let is_known = effects
            .last()
            .is_some_and(|last| last.effect.is_of_sensing());
        if let Some(body) = self.body.filter(|_| is_known) {
            return Some(model.predict(body, record, samples));
        }
        let body = self.body_of(&model, record, samples)?;
        Some(model.predict(&body, record, samples))
    }

    /// The cost of these effects on the fitted stretch, for a first look: the last one's
    /// size is whatever fits best of what a straight line from nothing to its values
    /// holds. Returns the effects with that size.
    pub(crate) fn glance(
        &self,
        comparison: &Comparison<'_>,
        without: &Prediction,
        mut effects: Vec<Placed>,
    ) -> Option<(f64, Vec<Placed>)> {
        let samples = comparison.record.fit().end;
        let with = self.predict(comparison, &effects, samples)?;
        let whole = comparison.settle(&with, &[]);
        let last = effects.last_mut()?;
        let parameters = last.parameters(self.model);
        let trace = Trace::between(without, &with);
        let settled = comparison.settle(without, std::slice::from_ref(&trace));
        let share = settled.sizes.last().copied().unwrap_or(1.0);
        let has_neutral = parameters.iter().all(|p| p.neutral.is_some());
        if !has_neutral || settled.cost >= whole.cost || !(0.02..=2.0).contains(&share) {
            return Some((whole.cost, effects));
        }
        for (value, parameter) in last.values.iter_mut().zip(&parameters) {
            let neutral = parameter.neutral.unwrap_or(0.0);
            let scaled = neutral + share * (*value - neutral);
            *value = scaled.clamp(parameter.lower, parameter.upper);
        }
        Some((settled.cost, effects))
    }

    /// The walk with these effects over the whole record, and what a sensor reports of its
    /// fitted stretch: to be glanced from.
    pub(crate) fn walked(
        &self,
        comparison: &Comparison<'_>,
        effects: &[Placed],
    ) -> Option<(OrientationSeries, Prediction)> {
        let model = self.with(effects);
        let record = comparison.record;
        let samples = record.times_s().len();
        let body = self.body_of(&model, record, samples)?;
        let predicted = model.predict(&body, record, record.fit().end);
        Some((body, predicted))
    }

    /// Fits the values of all effects from `first_free` on, from where they are, by Gauss
    /// and Newton's damped method with the usual differences fitted along, and where that leaves
    /// much and the effort is worth it, by polls of their neighbourhood. `None` when the walk diverges from the start.
    pub(crate) fn fit(
        &self,
        comparison: &Comparison<'_>,
        mut effects: Vec<Placed>,
        first_free: usize,
        effort: Effort,
    ) -> Option<Trial> {
        let samples = comparison.record.fit().end;
        let mut here = self.predict(comparison, &effects, samples)?;
        let mut settled = comparison.settle(&here, &[]);
        let mut last: Option<(Prediction, Vec<Trace>)> = None;
        for _ in 0..MAX_STEPS {
            let free = free_parameters(&effects, first_free, self.model);
            if free.is_empty() {
                break;
            }
            let traces: Option<Vec<Trace>> = free
                .par_iter()
                .map(|free| {
                    let step = free.step_inside();
                    let moved = self.predict(comparison, &free.moved(&effects, step), samples)?;
                    let mut trace = Trace::between(&here, &moved);
                    if step < 0.0 {
                        trace.reverse();
                    }
                    Some(trace)
                })
                .collect();
            let Some(traces) = traces else { break };
            let proposed = comparison.settle_damped(&here, &traces, DAMPING);
            last = Some((here.clone(), traces));
            let sizes = &proposed.sizes[comparison.usual()..];
            let mut gain = 0.0;
            for share in STEP_SHARES {
                let mut tried = effects.clone();
                for (free, size) in free.iter().zip(sizes) {
                    free.set(&mut tried, share * size * free.parameter.step);
                }
                let Some(there) = self.predict(comparison, &tried, samples) else {
                    continue;
                };
                let settled_there = comparison.settle(&there, &[]);
                if settled_there.cost < settled.cost {
                    gain = settled.cost - settled_there.cost;
                    (effects, here, settled) = (tried, there, settled_there);
                    break;
                }
            }
            if gain < SETTLED {
                break;
            }
        }
        if settled.is_rough() && effort == Effort::Polls {
            effects = self.polled(comparison, effects, first_free, settled.cost);
        }
        let linear = last.map(|(from, traces)| comparison.settle(&from, &traces));
        self.judge(comparison, effects, first_free, linear.as_ref())
    }

    /// Values around these that cost less. Robots that nearly tip over answer in jumps, which
    /// no slope foretells.
    fn polled(
        &self,
        comparison: &Comparison<'_>,
        effects: Vec<Placed>,
        first_free: usize,
        cost: f64,
    ) -> Vec<Placed> {
        let samples = comparison.record.fit().end;
        let around = |effects: &Vec<Placed>, width: f64| {
            free_parameters(effects, first_free, self.model)
                .iter()
                .flat_map(|free| [-width, width].map(|by| (free, by * free.parameter.step)))
                .map(|(free, by)| {
                    let mut moved = effects.clone();
                    free.set(&mut moved, by);
                    moved
                })
                .collect()
        };
        let found: Result<_, Infallible> = POLL.search(effects, cost, around, |moved| {
            let there = self.predict(comparison, moved, samples);
            Ok(there.map(|there| comparison.settle(&there, &[]).cost))
        });
        match found {
            Ok(effects) => effects,
        }
    }

    /// Measures effects with values as they are on both stretches.
    fn judge(
        &self,
        comparison: &Comparison<'_>,
        effects: Vec<Placed>,
        first_free: usize,
        linear: Option<&Settled>,
    ) -> Option<Trial> {
        let record = comparison.record;
        let predicted = self.predict(comparison, &effects, record.times_s().len())?;
        let settled = comparison.settle(&predicted, &[]);
        let widths = half_widths(&effects, first_free, self.model, comparison.usual(), linear);
        Some(Trial {
            cost: settled.cost,
            fit_deg2: settled.fit_deg2,
            unseen_deg2: settled.mean_square_deg2(record.unseen()),
            residual_deg: settled.residual_deg,
            half_width_95: widths,
            usual: settled.sizes.clone(),
            effects,
        })
    }
}

impl Trace {
    fn reverse(&mut self) {
        let axes = &mut self.angles_deg;
        for values in [&mut axes.roll, &mut axes.pitch, &mut axes.yaw] {
            values.iter_mut().for_each(|value| *value = -*value);
        }
        self.rest_rate_dps
            .iter_mut()
            .for_each(|rate| *rate = -*rate);
    }
}

/// One value that a fit may change.
struct Free {
    effect: usize,
    index: usize,
    value: f64,
    parameter: Parameter,
}

impl Free {
    /// A step that stays within the bounds.
    fn step_inside(&self) -> f64 {
        if self.value + self.parameter.step > self.parameter.upper {
            -self.parameter.step
        } else {
            self.parameter.step
        }
    }

    fn moved(&self, effects: &[Placed], by: f64) -> Vec<Placed> {
        let mut moved = effects.to_vec();
        moved[self.effect].values[self.index] += by;
        moved
    }

    fn set(&self, effects: &mut [Placed], by: f64) {
        let value = (self.value + by).clamp(self.parameter.lower, self.parameter.upper);
        effects[self.effect].values[self.index] = value;
    }
}

fn free_parameters(effects: &[Placed], first_free: usize, model: &WalkModel) -> Vec<Free> {
    let free = effects.iter().enumerate().skip(first_free);
    free.flat_map(|(effect, placed)| {
        let parameters = placed.parameters(model).into_iter().enumerate();
        parameters.map(move |(index, parameter)| Free {
            effect,
            index,
            value: placed.values[index],
            parameter,
        })
    })
    .collect()
}

/// Infinite where nothing was fitted.
fn half_widths(
    effects: &[Placed],
    first_free: usize,
    model: &WalkModel,
    usual: usize,
    linear: Option<&Settled>,
) -> Vec<Vec<f64>> {
    let mut widths: Vec<Vec<f64>> = effects
        .iter()
        .map(|placed| vec![f64::INFINITY; placed.values.len()])
        .collect();
    let none = DMatrix::zeros(0, 0);
    let covariance = linear.map_or(&none, |settled| &settled.covariance);
    let free = free_parameters(effects, first_free, model);
    for (k, free) in free.iter().enumerate() {
        if let Some(variance) = covariance.get((usual + k, usual + k)) {
            widths[free.effect][free.index] = NORMAL_95 * variance.sqrt() * free.parameter.step;
        }
    }
    widths
}
