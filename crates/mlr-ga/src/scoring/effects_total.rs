//! Scores of explanations, added up.

use mlr_residual::walk::{Reported, TracedEffect};
use serde::Serialize;

use super::{
    effects::{EffectsScore, KindsVerdict, TrueEffect},
    visibility::Visibility,
};

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
    /// Of the visible ones, those with two effects.
    pub two_effects: usize,
    /// Of these, both found.
    pub two_effects_found: usize,
    /// Effects of a leg in the visible ones whose kind was found.
    pub on_a_leg: usize,
    /// Of these, found on the right leg.
    pub on_the_right_leg: usize,
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
        let has_known_effect = |s: &EffectsScore| !s.truth.is_empty() && s.in_library;
        let is_visible = |s: &EffectsScore| has_known_effect(s) && s.visibility.is_visible();
        let visible = of(&is_visible);
        let standing_out = of(&|s| is_visible(s) && s.visibility != Visibility::WithinSpread);
        let two_effects = of(&|s| is_visible(s) && s.truth.len() > 1);
        let invisible = of(&|s| has_known_effect(s) && !s.visibility.is_visible());
        let undisturbed = of(&|s| s.truth.is_empty());
        let outside = of(&|s| !s.in_library);
        let outside_visible = of(&|s| !s.in_library && s.visibility.is_visible());
        let unexplained = |logs: &[&EffectsScore]| logs.iter().filter(|s| s.unexplained).count();
        let on_a_leg: Vec<bool> = visible
            .iter()
            .flat_map(|s| on_right_leg(&s.truth, &s.found))
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
            two_effects: two_effects.len(),
            two_effects_found: two_effects
                .iter()
                .filter(|s| are_all_found(&s.truth, &s.found))
                .count(),
            on_a_leg: on_a_leg.len(),
            on_the_right_leg: on_a_leg.iter().filter(|right| **right).count(),
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

/// Whether every effect's kind was found.
fn are_all_found(truth: &[TrueEffect], found: &[TracedEffect]) -> bool {
    let is_found = |truth: &TrueEffect| found.iter().any(|found| found.kind == truth.kind);
    truth.iter().all(is_found)
}

/// For each effect of a leg whose kind was found, whether it was found on its leg.
fn on_right_leg(truth: &[TrueEffect], found: &[TracedEffect]) -> Vec<bool> {
    truth
        .iter()
        .filter_map(|truth| {
            let leg = Reported::Number(truth.leg()?);
            let found = found.iter().find(|found| found.kind == truth.kind)?;
            Some(found.parameters.get("leg") == Some(&leg))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use mlr_residual::walk::StretchErrors;
    use serde_json::json;

    use super::*;

    const ERRORS: StretchErrors = StretchErrors {
        fit_deg: 1.0,
        validation_deg: 1.0,
        fit_axes_deg: [1.0; 3],
        validation_axes_deg: [1.0; 3],
    };

    fn truth(kind: &str, leg: u64) -> TrueEffect {
        TrueEffect {
            kind: kind.into(),
            parameters: [("leg".to_string(), json!(leg))].into(),
        }
    }

    fn found(kind: &str, leg: usize) -> TracedEffect {
        TracedEffect {
            kind: kind.into(),
            parameters: [("leg".to_string(), Reported::Number(leg))].into(),
            interval_95: BTreeMap::new(),
            at_bound: Vec::new(),
            undetermined: Vec::new(),
            explains: String::new(),
            gain: [0.0; 2],
            price: 0.0,
            chance: 0.0,
            error: ERRORS,
            rivals: Vec::new(),
        }
    }

    #[test]
    fn a_kind_that_was_found_may_be_on_another_leg() {
        let truths = [truth("short_link", 3), truth("weak_leg", 1)];
        let both = [found("weak_leg", 2), found("short_link", 3)];
        assert!(are_all_found(&truths, &both));
        assert_eq!(on_right_leg(&truths, &both), [true, false]);
        assert!(!are_all_found(&truths, &both[..1]));
        assert_eq!(on_right_leg(&truths, &both[..1]), [false]);
        assert!(on_right_leg(&truths, &[]).is_empty());
    }
}
