//! Explanations against what was done to the robots.

use std::{collections::BTreeMap, path::Path};

use mlr_imu::read_text;
use mlr_model::LegLayout;
use mlr_residual::walk::{
    ByAxis, RemainingResidual, Reported, StretchErrors, TracedEffect, WalkExplanation,
};
use serde::{Deserialize, Serialize};

use super::{
    truth::{FILE, MAX_BYTES, Truth, TruthError, read_truths},
    visibility::{TrueTrace, Visibility},
};

/// What was done to the robot of a log beyond its lost links.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectsTruth {
    /// The log, and what was left of the robot.
    pub log: Truth,
    /// Whether lost links are locked instead of absent.
    pub locked: bool,
    /// The undeclared effects.
    pub effects: Vec<TrueEffect>,
    /// Log time at which the walk was commanded.
    pub motion_start_s: Option<f64>,
    /// What they change of the walk, where that was recorded.
    pub trace: Option<TrueTrace>,
}

/// An effect as it was put into the robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrueEffect {
    /// Its kind.
    pub kind: String,
    /// Its parameters.
    #[serde(default)]
    pub parameters: BTreeMap<String, serde_json::Value>,
}

#[derive(Deserialize)]
struct Entry {
    #[serde(default)]
    locked: bool,
    #[serde(default)]
    effect: Option<OneEffect>,
    #[serde(default)]
    effects: Option<Vec<TrueEffect>>,
    #[serde(default)]
    motion_start_s: Option<f64>,
    #[serde(default)]
    trace: Option<TrueTrace>,
}

/// Some sets name a log's effect only.
#[derive(Deserialize)]
#[serde(untagged)]
enum OneEffect {
    Name(String),
    Whole(TrueEffect),
}

/// Reads a directory's `truth.json`: like [`read_truths`], with the effects.
///
/// # Errors
/// [`TruthError`] names the file and the entry at fault.
pub fn read_effects_truths(
    directory: &Path,
    layout: &LegLayout,
) -> Result<Vec<EffectsTruth>, TruthError> {
    let truths = read_truths(directory, layout)?;
    let path = directory.join(FILE);
    let fail = |problem: String| TruthError {
        path: path.clone(),
        problem,
    };
    let text = read_text(&path, MAX_BYTES).map_err(|error| fail(error.to_string()))?;
    let mut entries: BTreeMap<String, Entry> =
        serde_json::from_str(&text).map_err(|error| fail(error.to_string()))?;
    Ok(truths
        .into_iter()
        .filter_map(|log| {
            let entry = entries.remove(&log.name)?;
            let named = entry.effect.map(|effect| match effect {
                OneEffect::Name(kind) => TrueEffect {
                    kind,
                    parameters: BTreeMap::new(),
                },
                OneEffect::Whole(effect) => effect,
            });
            Some(EffectsTruth {
                log,
                locked: entry.locked,
                effects: entry.effects.unwrap_or_else(|| named.into_iter().collect()),
                motion_start_s: entry.motion_start_s,
                trace: entry.trace,
            })
        })
        .collect())
}

/// How right an explanation is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum KindsVerdict {
    /// Every effect found is in the robot, and at least one was found; or there is
    /// nothing in it and nothing was found.
    Right,
    /// The effect found is not in the robot, but a rival within noise is.
    Rival,
    /// Nothing was found.
    Missed,
    /// Nothing was found that is in the robot, and something that is not.
    Wrong,
    /// Some of what was found is not in the robot.
    Partly,
    /// The library has no such effect, and the log was marked as unexplained.
    Unexplained,
}

/// What became of one log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EffectsScore {
    /// Name of the log.
    pub log: String,
    /// What was done to the robot.
    pub truth: Vec<TrueEffect>,
    /// Whether that could be seen; see [`TrueTrace::visibility`].
    pub visibility: Visibility,
    /// Whether the library has every kind of it.
    pub in_library: bool,
    /// What was found.
    pub found: Vec<TracedEffect>,
    /// Whether more was left than the model usually leaves.
    pub unexplained: bool,
    /// What remains.
    pub residual: RemainingResidual,
    /// The same, split into its components.
    pub residual_after: ByAxis,
    /// How right that is.
    pub verdict: KindsVerdict,
    /// Error of the robot as described.
    pub error_before: StretchErrors,
    /// Error with the usual differences fitted.
    pub error_calibrated: StretchErrors,
    /// Error with the effects.
    pub error_after: StretchErrors,
    /// Whether the damaged legs were right before.
    pub legs_right_before: bool,
    /// Whether they are right with the effects in place.
    pub legs_right: bool,
    /// Whether every link is right with the effects in place.
    pub links_right: bool,
    /// How long it took.
    pub elapsed_s: f64,
}

/// Locked links: part of the damage, whether a set lists it or not.
const LOCKED: &str = "locked_links";

impl EffectsScore {
    /// Compares an explanation with the truth.
    pub fn new(truth: &EffectsTruth, found: &WalkExplanation, elapsed_s: f64) -> Self {
        let known = |kind: &str| kind == LOCKED || mlr_residual::walk_effects::find(kind).is_some();
        let in_library = truth.effects.iter().all(|effect| known(&effect.kind));
        let true_legs = truth.log.morphology.damaged_legs();
        Self {
            log: truth.log.name.clone(),
            truth: truth.effects.clone(),
            visibility: visibility(truth),
            in_library,
            found: found.effects.clone(),
            unexplained: found.unexplained,
            residual: found.residual.clone(),
            residual_after: found.residual_after.clone(),
            verdict: verdict(truth, found, in_library),
            error_before: found.error_before,
            error_calibrated: found.error_calibrated,
            error_after: found.error_after,
            legs_right_before: found.morphology_before.damaged_legs() == true_legs,
            legs_right: found.damaged_legs == true_legs,
            links_right: found.morphology == truth.log.morphology,
            elapsed_s,
        }
    }
}

/// A delay cannot be seen in a log that does not say when the walk was commanded.
fn visibility(truth: &EffectsTruth) -> Visibility {
    let is_a_delay = |effect: &TrueEffect| {
        mlr_residual::walk_effects::find(&effect.kind).is_some_and(|known| known.is_a_delay())
    };
    let only_delays = !truth.effects.is_empty() && truth.effects.iter().all(is_a_delay);
    match truth.trace {
        Some(_) if only_delays => Visibility::Hidden,
        Some(trace) => trace.visibility(),
        None => Visibility::Unknown,
    }
}

fn verdict(truth: &EffectsTruth, found: &WalkExplanation, in_library: bool) -> KindsVerdict {
    let is_true = |kind: &str| {
        truth.effects.iter().any(|effect| effect.kind == kind) || (kind == LOCKED && truth.locked)
    };
    let wanted = truth.effects.len();
    let counted: Vec<&TracedEffect> = found
        .effects
        .iter()
        .filter(|effect| effect.kind != LOCKED || truth.effects.iter().any(|t| t.kind == LOCKED))
        .collect();
    let right = counted
        .iter()
        .filter(|effect| is_true(&effect.kind))
        .count();
    let rival = counted
        .iter()
        .any(|effect| effect.rivals.iter().any(|rival| is_true(&rival.kind)));
    match (wanted, counted.len(), right) {
        _ if !in_library && found.unexplained => KindsVerdict::Unexplained,
        (0, 0, _) => KindsVerdict::Right,
        (_, 0, _) => KindsVerdict::Missed,
        (_, all, right) if right == all => KindsVerdict::Right,
        _ if rival => KindsVerdict::Rival,
        (_, _, 0) => KindsVerdict::Wrong,
        _ => KindsVerdict::Partly,
    }
}

/// The parameters of an effect, in words.
pub fn in_words(parameters: &BTreeMap<String, Reported>) -> String {
    let words = parameters
        .iter()
        .map(|(name, value)| format!("{name} {value}"));
    words.collect::<Vec<_>>().join(", ")
}

impl TrueEffect {
    /// The leg that it is on, if it is on one.
    pub(super) fn leg(&self) -> Option<usize> {
        let leg = self.parameters.get("leg")?.as_u64()?;
        usize::try_from(leg).ok()
    }

    /// Kind and parameters in words.
    pub fn in_words(&self) -> String {
        let parameters: BTreeMap<String, Reported> = self
            .parameters
            .iter()
            .filter_map(|(name, value)| {
                Some((name.clone(), serde_json::from_value(value.clone()).ok()?))
            })
            .collect();
        format!("{} {}", self.kind, in_words(&parameters))
            .trim_end()
            .to_string()
    }
}
