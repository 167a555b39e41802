//! What an explanation of a servo says.

use std::collections::{BTreeMap, BTreeSet};

use mlr_model::Servo;
use serde::Serialize;

use super::{ServoError, ServoModel, ServoRecording, search::Found};
use crate::{Posterior, statistics::rms};

/// Where the posterior of a parameter is wider than this share of its prior, the recordings do not
/// tell it.
const UNDETERMINED: f64 = 0.8;

/// What a servo on a bench has that its data sheet lacks.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ServoExplanation {
    /// The most probable effects, in the order in which they entered.
    pub effects: Vec<TracedServoEffect>,
    /// Probability of each kind, among the sets of effects that were fitted.
    pub effect_probability: BTreeMap<String, f64>,
    /// Effects that were tried last and did not enter.
    pub candidates: Vec<ServoCandidate>,
    /// Root mean square errors of every recording, those of the fit first.
    pub recordings: Vec<RecordingError>,
    /// The servo with its effects, for `[servo]` of a robot description.
    pub servo: Servo,
    /// Angle at which the arm hangs straight down, as fitted.
    pub hanging_rad: f64,
    /// Signals of every recording, for pictures.
    #[serde(skip)]
    pub signals: Vec<ServoSignals>,
}

/// What a recording shows and the models predict, rad.
#[derive(Debug, Clone, PartialEq)]
pub struct ServoSignals {
    /// Reported by the servo as described.
    pub before_rad: Vec<f64>,
    /// Reported by the servo with its effects.
    pub after_rad: Vec<f64>,
}

/// An effect that entered.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TracedServoEffect {
    /// Name of the effect.
    pub kind: String,
    /// Its parameters, in the units of their names.
    pub parameters: BTreeMap<String, f64>,
    /// Their 95 % intervals.
    pub interval_95: BTreeMap<String, [f64; 2]>,
    /// Parameters that the recordings do not tell.
    pub undetermined: Vec<String>,
    /// What it leaves in the residual.
    pub explains: String,
    /// By how much the logarithm of evidence times prior grew when it entered.
    pub ln_gain: f64,
    /// Median error of the fitted recordings when it had entered, degrees.
    pub fit_deg: f64,
    /// Probability that the servo has it.
    pub probability: f64,
}

/// An effect that did not enter.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ServoCandidate {
    /// Name of the effect.
    pub kind: String,
    /// By how much the logarithm of evidence times prior would have grown.
    pub ln_gain: f64,
}

/// Errors of a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RecordingError {
    /// The recording.
    pub recording: String,
    /// Whether effects and parameters were chosen on it.
    pub fitted: bool,
    /// Root mean square error of the servo as described, degrees.
    pub before_deg: f64,
    /// The same with its effects.
    pub after_deg: f64,
}

pub(super) fn explanation(
    described: &ServoModel,
    fitted: &[ServoRecording],
    unseen: &[ServoRecording],
    found: &Found<'_>,
) -> Result<ServoExplanation, (usize, ServoError)> {
    let best = &found.best;
    let model = best.hypothesis.model(&best.z);
    let mut recordings = Vec::new();
    let mut signals = Vec::new();
    for (index, recording) in fitted.iter().chain(unseen).enumerate() {
        let diverged = (index, ServoError::Diverged);
        let predicted = |model: &ServoModel| model.predicted_rad(recording).ok_or(diverged.clone());
        let (before_rad, after_rad) = (predicted(described)?, predicted(&model)?);
        recordings.push(RecordingError {
            recording: recording.name.clone(),
            fitted: index < fitted.len(),
            before_deg: error_deg(recording, &before_rad),
            after_deg: error_deg(recording, &after_rad),
        });
        signals.push(ServoSignals {
            before_rad,
            after_rad,
        });
    }
    let posterior = Posterior::new(best_of_each_set(&found.fitted));
    let probability = |kind: &str| posterior.sum(|kinds| kinds.contains(kind));
    let seen = found.fitted.iter().flat_map(|(kinds, _)| kinds);
    let tried = found
        .tried
        .iter()
        .filter(|(effect, _)| !best.hypothesis.has(effect.kind()));
    Ok(ServoExplanation {
        effects: traced(found, probability),
        effect_probability: seen
            .map(|kind| ((*kind).to_string(), probability(kind)))
            .collect(),
        candidates: tried
            .map(|(effect, gain)| ServoCandidate {
                kind: effect.kind().into(),
                ln_gain: *gain,
            })
            .collect(),
        recordings,
        hanging_rad: model.bench.arm.hanging_rad,
        servo: model.bench.servo,
        signals,
    })
}

/// Every set of effects once, as it was fitted best.
fn best_of_each_set(fitted: &[(Vec<&'static str>, f64)]) -> BTreeMap<BTreeSet<&'static str>, f64> {
    let mut sets = BTreeMap::new();
    for (kinds, ln_weight) in fitted {
        let best = sets
            .entry(kinds.iter().copied().collect())
            .or_insert(f64::NEG_INFINITY);
        *best = f64::max(*best, *ln_weight);
    }
    sets
}

fn error_deg(recording: &ServoRecording, predicted_rad: &[f64]) -> f64 {
    let pairs = recording.positions_rad.iter().zip(predicted_rad);
    let errors = pairs.map(|(reported, predicted)| reported - predicted);
    rms(&errors.collect::<Vec<f64>>()).to_degrees()
}

fn traced(found: &Found<'_>, probability: impl Fn(&str) -> f64) -> Vec<TracedServoEffect> {
    let best = &found.best;
    let entered = |kind: &str| {
        let mut steps = found.steps.windows(2).enumerate();
        steps.find(|(_, pair)| pair[1].hypothesis.has(kind) && !pair[0].hypothesis.has(kind))
    };
    let covariance = best.covariance();
    let described = best.hypothesis.described();
    let mut traced: Vec<(usize, TracedServoEffect)> = Vec::new();
    for (effect, range) in best.hypothesis.effects.iter().zip(best.hypothesis.ranges()) {
        let entered = entered(effect.kind());
        let reported_at = |z: &dyn Fn(usize) -> f64| {
            let values = range
                .clone()
                .map(|k| best.hypothesis.parameter(k).value(z(k)));
            effect.report(&values.collect::<Vec<f64>>(), described)
        };
        let deviation = |k: usize| covariance[(k, k)].max(0.0).sqrt();
        let low = reported_at(&|k| best.z[k] - 1.96 * deviation(k));
        let high = reported_at(&|k| best.z[k] + 1.96 * deviation(k));
        let interval = |(name, low): (String, f64)| {
            let high = high.get(&name).copied().unwrap_or(low);
            (name, [low.min(high), low.max(high)])
        };
        let parameters = reported_at(&|k| best.z[k]);
        let wide = range.clone().filter(|k| deviation(*k) > UNDETERMINED);
        let place = entered.map_or(usize::MAX, |(place, _)| place);
        let effect = TracedServoEffect {
            kind: effect.kind().into(),
            interval_95: low.into_iter().map(interval).collect(),
            undetermined: wide
                .map(|k| best.hypothesis.parameter(k).name.to_string())
                .collect(),
            parameters,
            explains: effect.signature().into(),
            ln_gain: entered.map_or(0.0, |(_, pair)| pair[1].ln_weight - pair[0].ln_weight),
            fit_deg: entered.map_or(f64::NAN, |(_, pair)| pair[1].median_error_deg()),
            probability: probability(effect.kind()),
        };
        traced.push((place, effect));
    }
    traced.sort_by_key(|(place, _)| *place);
    traced.into_iter().map(|(_, effect)| effect).collect()
}
