//! Explanations against what was done to the robots.

use std::{collections::BTreeMap, fs, path::Path};

use mlr_model::LegLayout;
use mlr_residual::walk::{
    ByAxis, RemainingResidual, Reported, StretchErrors, TracedEffect, WalkExplanation,
};
use serde::{Deserialize, Serialize};

use super::{
    truth::{FILE, Truth, TruthError, read_truths},
    visibility::{TrueTrace, Visibility},
};

/// What was done to the robot of a log beyond its lost links.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectsTruth {
    /// The log, and what was left of the robot.
    pub log: Truth,
    /// Whether lost links hang on as dead weight.
    pub locked: bool,
    /// What nothing in the log declares.
    pub effects: Vec<TrueEffect>,
    /// Log time at which the walk was commanded.
    pub motion_start_s: Option<f64>,
    /// What it changes of the walk, where that was recorded.
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
    let text = fs::read_to_string(&path).map_err(|error| fail(error.to_string()))?;
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
    /// Nothing was found, and it was not marked as unexplained.
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
    /// The same, split into what physics tells apart.
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

/// Lost links that hang on: part of the damage, whether a set lists it or not.
const LOCKED: &str = "locked_links";

impl EffectsScore {
    /// Compares an explanation with the truth.
    pub fn new(truth: &EffectsTruth, found: &WalkExplanation, elapsed_s: f64) -> Self {
        let known = |kind: &str| kind == LOCKED || mlr_residual::walk_effects::find(kind).is_some();
        let in_library = truth.effects.iter().all(|effect| known(&effect.kind));
        let legs = |rows: &[Vec<u8>]| -> Vec<usize> {
            let damaged = rows.iter().enumerate().filter(|(_, leg)| leg.contains(&0));
            damaged.map(|(leg, _)| leg + 1).collect()
        };
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
            legs_right_before: legs(&found.morphology_before) == true_legs,
            legs_right: found.damaged_legs == true_legs,
            links_right: found.morphology == truth.log.morphology.to_rows(),
            elapsed_s,
        }
    }
}

/// A delay shows nowhere in a log that does not tell when the walk was commanded.
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

/// All logs together.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EffectsTotal {
    /// Logs with a visible effect that the library has.
    pub visible: usize,
    /// Of these, right kinds.
    pub visible_right: usize,
    /// Of these, wrong ones with the right kind among their rivals.
    pub visible_rival: usize,
    /// Of the visible ones, those that stand out of the spread of robots or whose spread is not
    /// known.
    pub standing_out: usize,
    /// Of these, right kinds.
    pub standing_out_right: usize,
    /// Logs with an effect of the library that cannot be seen.
    pub invisible: usize,
    /// Of these, nothing wrong found.
    pub invisible_right_or_none: usize,
    /// Logs without any effect.
    pub undisturbed: usize,
    /// Of these, nothing found.
    pub undisturbed_none: usize,
    /// Of these, marked as unexplained.
    pub undisturbed_unexplained: usize,
    /// Logs with an effect that the library does not have.
    pub outside: usize,
    /// Of these, marked as unexplained.
    pub outside_unexplained: usize,
    /// Of those outside the library, the visible ones.
    pub outside_visible: usize,
    /// Of the visible ones outside the library, marked as unexplained.
    pub outside_visible_unexplained: usize,
    /// Median of the error after over the error before, unseen stretch, of logs with a
    /// visible effect that the library has.
    pub median_error_ratio: Option<f64>,
    /// The same against the error with the usual differences fitted.
    pub median_calibrated_ratio: Option<f64>,
    /// Legs right before and after.
    pub legs_right: [usize; 2],
    /// Longest time.
    pub longest_elapsed_s: f64,
}

impl EffectsTotal {
    /// Adds up scores.
    pub fn new(scores: &[EffectsScore]) -> Self {
        let right = |score: &&&EffectsScore| matches!(score.verdict, KindsVerdict::Right);
        let of = |wanted: &dyn Fn(&EffectsScore) -> bool| -> Vec<&EffectsScore> {
            scores.iter().filter(|score| wanted(score)).collect()
        };
        let visible = of(&|s| !s.truth.is_empty() && s.in_library && s.visibility.is_visible());
        let invisible = of(&|s| !s.truth.is_empty() && s.in_library && !s.visibility.is_visible());
        let undisturbed = of(&|s| s.truth.is_empty());
        let outside = of(&|s| !s.in_library);
        let unexplained = |logs: &[&EffectsScore]| logs.iter().filter(|s| s.unexplained).count();
        let outside_visible: Vec<&EffectsScore> = outside
            .iter()
            .copied()
            .filter(|s| s.visibility.is_visible())
            .collect();
        let standing_out: Vec<&EffectsScore> = visible
            .iter()
            .copied()
            .filter(|s| s.visibility != Visibility::WithinSpread)
            .collect();
        let ratio = |before: &dyn Fn(&EffectsScore) -> f64| {
            let mut ratios: Vec<f64> = visible
                .iter()
                .map(|s| s.error_after.validation_deg / before(s))
                .collect();
            ratios.sort_by(f64::total_cmp);
            ratios.get(ratios.len() / 2).copied()
        };
        let invisible_ok =
            |s: &&&EffectsScore| !matches!(s.verdict, KindsVerdict::Wrong | KindsVerdict::Partly);
        Self {
            visible: visible.len(),
            visible_right: visible.iter().filter(right).count(),
            visible_rival: visible
                .iter()
                .filter(|s| s.verdict == KindsVerdict::Rival)
                .count(),
            standing_out: standing_out.len(),
            standing_out_right: standing_out.iter().filter(right).count(),
            invisible: invisible.len(),
            invisible_right_or_none: invisible.iter().filter(invisible_ok).count(),
            undisturbed: undisturbed.len(),
            undisturbed_none: undisturbed.iter().filter(right).count(),
            undisturbed_unexplained: unexplained(&undisturbed),
            outside: outside.len(),
            outside_unexplained: unexplained(&outside),
            outside_visible: outside_visible.len(),
            outside_visible_unexplained: unexplained(&outside_visible),
            median_error_ratio: ratio(&|s| s.error_before.validation_deg),
            median_calibrated_ratio: ratio(&|s| s.error_calibrated.validation_deg),
            legs_right: [
                scores.iter().filter(|s| s.legs_right_before).count(),
                scores.iter().filter(|s| s.legs_right).count(),
            ],
            longest_elapsed_s: scores.iter().map(|s| s.elapsed_s).fold(0.0, f64::max),
        }
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
