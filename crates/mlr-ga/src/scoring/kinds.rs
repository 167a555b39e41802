//! The probabilities that an explanation gives to kinds of effects, against the truth.

use std::collections::{BTreeMap, BTreeSet};

use mlr_residual::walk_effects::LIBRARY;
use serde::{Deserialize, Serialize};

use super::effects_truth::{LOCKED, NONE, TrueKinds, UNKNOWN};

/// Probabilities below it count as this much in a logarithmic score: nothing tells a smaller one
/// from it on so few logs, and a single zero would make the mean infinite.
pub const LOG_SCORE_FLOOR: f64 = 1e-3;
/// Probability that a credible set holds at least.
const CREDIBLE: f64 = 0.9;
/// Answers that give a kind more than this are called sure.
pub const SURE: f64 = 0.9;

/// "The robot has an effect of this kind", with the probability given to that.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Statement {
    /// The kind; `none` and `unknown` are kinds as well.
    pub kind: String,
    /// How probable the explanation called it.
    pub probability: f64,
    /// Whether it is true.
    pub is_true: bool,
}

/// How good the probabilities of one explanation are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct KindsScore {
    /// Every kind of the library, `locked_links`, `none` and `unknown`. A delay is among them only
    /// where it was tried.
    ///
    /// Taken at their word: `none` is false of a robot whose lost links hang on.
    pub statements: Vec<Statement>,
    /// Natural logarithm of the probability given to the truth, at least
    /// ln([`LOG_SCORE_FLOOR`]); of several effects, the mean.
    ///
    /// The probability of nothing but lost links that hang on, unlisted, is what the other kinds
    /// leave.
    pub ln_probability: f64,
    /// Brier score: the sum over all statements of (probability − truth)².
    pub brier: f64,
    /// Kinds of which every one that the robot has is among with 90 % probability.
    pub credible: BTreeSet<String>,
    /// Whether that is so.
    pub credible_holds_truth: bool,
    /// Kinds that have more than [`SURE`], `none` here for nothing but lost links, gone or not.
    pub sure: Vec<String>,
    /// Whether the robot has all of these.
    pub sure_is_true: bool,
}

impl KindsScore {
    /// Compares the probabilities of kinds with the truth.
    ///
    /// A robot may have several kinds at once, so that probabilities may add to more than 1. The
    /// credible set is the smallest, by descending probability, outside of which no more than
    /// 10 % is left. The robot then has a kind outside of it with at most that probability
    /// (Boole's inequality); where probabilities add to 1, it is the usual one, which holds 90 %.
    /// Whether lost links hang on belongs to the damage: `locked_links` is not in the set, `none`
    /// stands for nothing but lost links, and where locked links are listed as an effect they must
    /// have more than 10 % besides.
    pub(super) fn new(given: &BTreeMap<String, f64>, truth: &TrueKinds, start_told: bool) -> Self {
        let statements = statements(given, truth, start_told);
        let beyond = beyond_damage(given);
        let credible = credible_set(&beyond);
        let is_true_beyond = |kind: &str| match kind {
            NONE => truth.is_damage_only(),
            kind => truth.has(kind),
        };
        let links_covered = !truth.effects.contains(LOCKED)
            || given.get(LOCKED).copied().unwrap_or(0.0) > 1.0 - CREDIBLE;
        let effects = truth.effects.iter().filter(|kind| *kind != LOCKED);
        let kinds_covered = match truth.is_damage_only() {
            true => credible.contains(NONE),
            false => effects.into_iter().all(|kind| credible.contains(kind)),
        };
        let sure: Vec<String> = beyond
            .iter()
            .filter(|(_, probability)| **probability > SURE)
            .map(|(kind, _)| kind.clone())
            .collect();
        Self {
            ln_probability: ln_probability(given, &beyond, truth),
            brier: statements
                .iter()
                .map(|one| (one.probability - f64::from(u8::from(one.is_true))).powi(2))
                .sum(),
            statements,
            credible_holds_truth: links_covered && kinds_covered,
            credible,
            sure_is_true: sure.iter().all(|kind| is_true_beyond(kind)),
            sure,
        }
    }

    /// The so many most probable kinds, the most probable first.
    pub fn top(&self, count: usize) -> Vec<&Statement> {
        let mut sorted: Vec<&Statement> = self.statements.iter().collect();
        sorted.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        sorted.truncate(count);
        sorted
    }
}

fn statements(
    given: &BTreeMap<String, f64>,
    truth: &TrueKinds,
    start_told: bool,
) -> Vec<Statement> {
    let tried = LIBRARY
        .iter()
        .filter(|effect| start_told || !effect.is_a_delay())
        .map(|effect| effect.kind());
    let kinds: BTreeSet<&str> = tried
        .chain([LOCKED, NONE, UNKNOWN])
        .chain(given.keys().map(String::as_str))
        .collect();
    kinds
        .into_iter()
        .map(|kind| Statement {
            kind: kind.to_string(),
            probability: given.get(kind).copied().unwrap_or(0.0),
            is_true: truth.has(kind),
        })
        .collect()
}

/// The probabilities of what is wrong beside the lost links: `none` is at least what all other
/// kinds leave, because lost links may hang on.
fn beyond_damage(given: &BTreeMap<String, f64>) -> BTreeMap<String, f64> {
    let mut beyond = given.clone();
    beyond.remove(LOCKED);
    let none = beyond.remove(NONE).unwrap_or(0.0);
    let others: f64 = beyond.values().sum();
    beyond.insert(NONE.into(), none.max(1.0 - others));
    beyond
}

fn credible_set(probabilities: &BTreeMap<String, f64>) -> BTreeSet<String> {
    let mut rising: Vec<(&String, f64)> = probabilities.iter().map(|(k, p)| (k, *p)).collect();
    rising.sort_by(|a, b| a.1.total_cmp(&b.1));
    // Rounding must not let a kind in.
    let most_left = 1.0 - CREDIBLE + 1e-9;
    let mut left = 0.0;
    rising
        .into_iter()
        .filter(|(_, probability)| {
            left += probability;
            left > most_left
        })
        .map(|(kind, _)| kind.clone())
        .collect()
}

fn ln_probability(
    given: &BTreeMap<String, f64>,
    beyond_damage: &BTreeMap<String, f64>,
    truth: &TrueKinds,
) -> f64 {
    let ln = |probability: Option<&f64>| {
        let probability = probability.copied().unwrap_or(0.0);
        probability.clamp(LOG_SCORE_FLOOR, 1.0).ln()
    };
    if truth.effects.is_empty() {
        let probabilities = if truth.locked { beyond_damage } else { given };
        return ln(probabilities.get(NONE));
    }
    let each = truth.effects.iter().map(|kind| ln(given.get(kind)));
    each.sum::<f64>() / truth.effects.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn truth(effects: &[&str], locked: bool) -> TrueKinds {
        TrueKinds {
            effects: effects.iter().map(ToString::to_string).collect(),
            locked: locked || effects.contains(&LOCKED),
        }
    }

    fn given(probabilities: &[(&str, f64)]) -> BTreeMap<String, f64> {
        let each = probabilities.iter();
        each.map(|(kind, p)| (kind.to_string(), *p)).collect()
    }

    fn score(probabilities: &[(&str, f64)], effects: &[&str], locked: bool) -> KindsScore {
        KindsScore::new(&given(probabilities), &truth(effects, locked), false)
    }

    fn credible(probabilities: &[(&str, f64)]) -> Vec<String> {
        score(probabilities, &[], false)
            .credible
            .into_iter()
            .collect()
    }

    #[test]
    fn the_credible_set_holds_ninety_per_cent() {
        let three = [("payload", 0.7), ("slope", 0.21), ("unknown", 0.09)];
        assert_eq!(credible(&three), ["payload", "slope"]);
        assert_eq!(credible(&[("payload", 0.95), ("slope", 0.05)]), ["payload"]);
        assert_eq!(credible(&[("payload", 0.9), ("slope", 0.1)]), ["payload"]);
        let even = [
            ("none", 0.25),
            ("payload", 0.25),
            ("slope", 0.25),
            ("unknown", 0.25),
        ];
        assert_eq!(credible(&even).len(), 4);
    }

    #[test]
    fn two_effects_at_once_are_both_in_the_set() {
        // Each has 90 % and more, but one alone leaves the other out.
        let both = [("payload", 1.0), ("slope", 0.95), ("friction", 0.05)];
        assert_eq!(credible(&both), ["payload", "slope"]);
        assert!(score(&both, &["payload", "slope"], false).credible_holds_truth);
        assert!(!score(&both, &["payload", "friction"], false).credible_holds_truth);
    }

    #[test]
    fn lost_links_that_hang_on_are_no_kind_of_the_set() {
        let surely_locked = [("locked_links", 1.0), ("none", 0.0), ("unknown", 0.0)];
        let undisturbed = score(&surely_locked, &[], true);
        assert_eq!(credible(&surely_locked), ["none"]);
        assert!(undisturbed.credible_holds_truth);
        assert!(undisturbed.ln_probability.abs() < 1e-9);
        assert!(score(&surely_locked, &["locked_links"], true).credible_holds_truth);
        let surely_gone = [("none", 1.0)];
        assert!(!score(&surely_gone, &["locked_links"], true).credible_holds_truth);
        // Sure of another effect is not covered by being sure of locked links.
        let with_payload = [("locked_links", 1.0), ("payload", 1.0)];
        assert!(!score(&with_payload, &[], true).credible_holds_truth);
    }

    #[test]
    fn the_log_score_is_that_of_the_truth() {
        let probabilities = [
            ("payload", 0.5),
            ("slope", 0.2),
            ("none", 0.2),
            ("unknown", 0.1),
        ];
        let ln = |effects: &[&str]| score(&probabilities, effects, false).ln_probability;
        assert!((ln(&["payload"]) - 0.5_f64.ln()).abs() < 1e-12);
        assert!((ln(&[]) - 0.2_f64.ln()).abs() < 1e-12);
        assert!((ln(&["unknown"]) - 0.1_f64.ln()).abs() < 1e-12);
        assert!((ln(&["friction"]) - LOG_SCORE_FLOOR.ln()).abs() < 1e-12);
        let mean = 0.5 * (0.5_f64.ln() + 0.2_f64.ln());
        assert!((ln(&["payload", "slope"]) - mean).abs() < 1e-12);
        // Links that are gone are not as good as locked where they are gone.
        let locked = score(&[("locked_links", 0.7), ("none", 0.3)], &[], false);
        assert!((locked.ln_probability - 0.3_f64.ln()).abs() < 1e-12);
    }

    #[test]
    fn the_brier_score_counts_every_kind() {
        let right = score(&[("payload", 1.0)], &["payload"], false);
        assert!(right.brier.abs() < 1e-12);
        let wrong = score(&[("slope", 1.0)], &["payload"], false);
        assert!((wrong.brier - 2.0).abs() < 1e-12);
        let half = score(&[("payload", 0.5), ("slope", 0.5)], &["payload"], false);
        assert!((half.brier - 0.5).abs() < 1e-12);
    }

    #[test]
    fn delays_are_statements_where_they_were_tried() {
        let none = given(&[("none", 1.0)]);
        let has_delay = |score: &KindsScore| {
            let kinds = score.statements.iter().map(|one| one.kind.as_str());
            kinds.filter(|kind| *kind == "sensor_delay").count() == 1
        };
        let untold = KindsScore::new(&none, &truth(&[], false), false);
        let told = KindsScore::new(&none, &truth(&[], false), true);
        assert!(!has_delay(&untold) && has_delay(&told));
        assert_eq!(untold.statements.len() + 2, told.statements.len());
    }

    #[test]
    fn sure_answers_are_right_or_not() {
        let sure = |p: f64, effects: &[&str]| {
            let score = score(&[("payload", p), ("none", 1.0 - p)], effects, false);
            (score.sure, score.sure_is_true)
        };
        assert_eq!(sure(0.95, &["payload"]), (vec!["payload".into()], true));
        assert_eq!(sure(0.95, &["slope"]), (vec!["payload".into()], false));
        assert_eq!(sure(0.9, &["payload"]).0, Vec::<String>::new());
    }
}
