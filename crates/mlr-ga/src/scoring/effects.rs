//! Explanations against what was done to the robots.

use std::collections::{BTreeMap, BTreeSet};

use mlr_residual::walk::{self, Reported, TracedEffect, WalkExplanation};
use serde::{Deserialize, Serialize};

use super::{
    effects_truth::{EffectsTruth, LogClass, Origin, TrueEffect, TrueKinds, UNKNOWN},
    kinds::KindsScore,
    visibility::Visibility,
};

/// How right an explanation is. `unexplained` counts as an effect that was found: the right one
/// where the library lacks an effect of the log, one that is not there elsewhere.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// All effects of the robot were found and no other, and the damaged legs are right.
    Right,
    /// All that was found is in the robot and the legs are right, but some effects were not found.
    Incomplete,
    /// Some of what was found is in the robot, and some is not.
    Partly,
    /// All that was found is in the robot, but other legs are damaged.
    WrongLegs,
    /// Nothing was found of what is in the robot, and nothing that is not.
    Missed,
    /// Nothing was found of what is in the robot, and something that is not.
    Wrong,
}

impl Verdict {
    /// All of them, from right to wrong.
    pub const ALL: [Self; 6] = [
        Self::Right,
        Self::Incomplete,
        Self::Partly,
        Self::WrongLegs,
        Self::Missed,
        Self::Wrong,
    ];

    fn new(truth: &TrueKinds, found: &BTreeSet<&str>, legs_right: bool) -> Self {
        let any_false = found.iter().any(|kind| !truth.has(kind));
        let is_found = |kind: &&String| found.contains(kind.as_str());
        let true_found = truth.effects.iter().filter(is_found).count();
        match (any_false, true_found) {
            (true, 0) => Self::Wrong,
            (true, _) => Self::Partly,
            (false, 0) if !truth.effects.is_empty() => Self::Missed,
            _ if !legs_right => Self::WrongLegs,
            (false, all) if all == truth.effects.len() => Self::Right,
            _ => Self::Incomplete,
        }
    }
}

/// What became of one log.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct EffectsScore {
    /// Name of the log.
    pub log: String,
    /// Where it comes from.
    pub origin: Origin,
    /// What there was to find.
    pub class: LogClass,
    /// What was done to the robot.
    pub truth: Vec<TrueEffect>,
    /// Whether that can be seen; see [`super::TrueTrace::visibility`].
    pub visibility: Visibility,
    /// What was found.
    pub found: Vec<FoundEffect>,
    /// Whether something that no effect of the library makes was held more probable than not.
    pub unexplained: bool,
    /// How right that is.
    pub verdict: Verdict,
    /// How right it were without the mark `unexplained`.
    pub verdict_but_for_mark: Verdict,
    /// For each effect of the robot that is on a leg, where it was found.
    pub places: Vec<PlaceScore>,
    /// The probabilities of kinds against the truth.
    pub kinds: KindsScore,
    /// Error of the robot as described.
    pub error_before: Errors,
    /// Error with the nuisance parameters fitted.
    pub error_calibrated: Errors,
    /// Error with the effects.
    pub error_after: Errors,
    /// Whether the damaged legs were right before.
    pub legs_right_before: bool,
    /// Whether they are right with the effects in place.
    pub legs_right: bool,
    /// Whether every link is right with the effects in place.
    pub links_right: bool,
    /// How long it took.
    pub elapsed_s: f64,
}

/// A log that has no explanation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct UnansweredLog {
    /// Name of the log.
    pub log: String,
    /// Where it comes from.
    pub origin: Origin,
    /// What there was to find.
    pub class: LogClass,
    /// What was done to the robot.
    pub truth: Vec<TrueEffect>,
    /// Why it has none.
    pub reason: String,
}

impl UnansweredLog {
    /// A log without an explanation.
    pub fn new(truth: &EffectsTruth, start_told: bool, reason: String) -> Self {
        Self {
            log: truth.log.name.clone(),
            origin: truth.origin,
            class: truth.class(start_told),
            truth: truth.effects.clone(),
            reason,
        }
    }
}

/// An effect as it was found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FoundEffect {
    /// Its kind.
    pub kind: String,
    /// Its parameters.
    pub parameters: BTreeMap<String, Reported>,
    /// Probability of its kind.
    pub probability: f64,
}

impl From<&TracedEffect> for FoundEffect {
    fn from(effect: &TracedEffect) -> Self {
        Self {
            kind: effect.kind.clone(),
            parameters: effect.parameters.clone(),
            probability: effect.probability,
        }
    }
}

/// Root mean square errors over all axes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Errors {
    /// On the stretch that parameters were fitted on.
    pub fit_deg: f64,
    /// On the stretch that nothing has seen.
    pub validation_deg: f64,
}

impl From<walk::StretchErrors> for Errors {
    fn from(errors: walk::StretchErrors) -> Self {
        Self {
            fit_deg: errors.fit_deg,
            validation_deg: errors.validation_deg,
        }
    }
}

/// Where an effect of a leg was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PlaceScore {
    /// Whether its kind was found at all.
    pub kind_found: bool,
    /// Whether on its leg.
    pub leg_right: bool,
    /// Whether on its leg and its link or joint, where it is on one.
    pub place_right: bool,
}

/// Parameters that say where an effect is.
const PLACE: [&str; 3] = ["leg", "link", "joint"];

impl PlaceScore {
    /// `None` for an effect that is on no leg.
    fn new(truth: &TrueEffect, found: &[FoundEffect]) -> Option<Self> {
        truth.number("leg")?;
        let of_kind = || found.iter().filter(|found| found.kind == truth.kind);
        let is_right = |found: &FoundEffect, name: &str| match truth.number(name) {
            Some(number) => found.parameters.get(name) == Some(&Reported::Number(number)),
            None => true,
        };
        Some(Self {
            kind_found: of_kind().next().is_some(),
            leg_right: of_kind().any(|found| is_right(found, "leg")),
            place_right: of_kind().any(|found| PLACE.iter().all(|name| is_right(found, name))),
        })
    }
}

impl EffectsScore {
    /// Compares an explanation with the truth. `start_told`: whether the explanation was told when
    /// the walk was commanded.
    pub fn new(
        truth: &EffectsTruth,
        answer: &WalkExplanation,
        start_told: bool,
        elapsed_s: f64,
    ) -> Self {
        let kinds = truth.kinds();
        let true_legs = truth.log.morphology.damaged_legs();
        let legs_right = answer.damaged_legs == true_legs;
        let found: Vec<FoundEffect> = answer.effects.iter().map(FoundEffect::from).collect();
        let mut found_kinds: BTreeSet<&str> = found.iter().map(|one| one.kind.as_str()).collect();
        let is_outside = truth.class(start_told).is_outside();
        let mut verdict_but_for_mark = Verdict::new(&kinds, &found_kinds, legs_right);
        if answer.unexplained {
            found_kinds.insert(UNKNOWN);
        }
        let verdict = Verdict::new(&kinds, &found_kinds, legs_right);
        if is_outside {
            verdict_but_for_mark = verdict;
        }
        Self {
            log: truth.log.name.clone(),
            origin: truth.origin,
            class: truth.class(start_told),
            truth: truth.effects.clone(),
            visibility: truth.visibility(start_told),
            unexplained: answer.unexplained,
            verdict,
            verdict_but_for_mark,
            places: truth
                .effects
                .iter()
                .filter_map(|effect| PlaceScore::new(effect, &found))
                .collect(),
            kinds: KindsScore::new(&answer.effect_probability, &kinds, start_told),
            error_before: answer.error_before.into(),
            error_calibrated: answer.error_calibrated.into(),
            error_after: answer.error_after.into(),
            legs_right_before: answer.morphology_before.damaged_legs() == true_legs,
            legs_right,
            links_right: answer.morphology == truth.log.morphology,
            elapsed_s,
            found,
        }
    }

    /// Whether every effect of the robot's that the library has was found, whatever else was.
    pub(super) fn found_all(&self) -> bool {
        let is_found = |truth: &TrueEffect| self.found.iter().any(|one| one.kind == truth.kind);
        self.truth.iter().all(is_found)
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::{super::effects_truth::LOCKED, *};

    /// A robot with these effects; locked links are gone unless `locked`.
    fn verdict(effects: &[&str], locked: bool, found: &[&str], legs_right: bool) -> Verdict {
        let truth = TrueKinds {
            effects: effects.iter().map(ToString::to_string).collect(),
            locked: locked || effects.contains(&LOCKED),
        };
        Verdict::new(&truth, &found.iter().copied().collect(), legs_right)
    }

    #[test]
    fn all_and_nothing_else_is_right() {
        assert_eq!(
            verdict(&["payload"], false, &["payload"], true),
            Verdict::Right
        );
        assert_eq!(verdict(&[], false, &[], true), Verdict::Right);
        let both = ["payload", "slope"];
        assert_eq!(verdict(&both, false, &both, true), Verdict::Right);
        assert_eq!(verdict(&both, false, &["slope"], true), Verdict::Incomplete);
    }

    #[test]
    fn an_answer_with_wrong_legs_is_never_right() {
        for (effects, found) in [
            (vec![], vec![]),
            (vec!["payload"], vec!["payload"]),
            (vec!["payload", "slope"], vec!["slope"]),
            (vec!["unknown"], vec!["unknown"]),
            (vec!["locked_links"], vec!["locked_links"]),
        ] {
            assert_eq!(verdict(&effects, false, &found, false), Verdict::WrongLegs);
            assert_ne!(verdict(&effects, false, &found, true), Verdict::WrongLegs);
        }
        assert_eq!(verdict(&["payload"], false, &[], false), Verdict::Missed);
    }

    #[test]
    fn what_is_not_there_counts_against_an_answer() {
        assert_eq!(verdict(&[], false, &["payload"], true), Verdict::Wrong);
        assert_eq!(
            verdict(&["slope"], false, &["payload"], true),
            Verdict::Wrong
        );
        let with_another = ["payload", "slope"];
        assert_eq!(
            verdict(&["slope"], false, &with_another, true),
            Verdict::Partly
        );
        assert_eq!(verdict(&["slope"], false, &[], true), Verdict::Missed);
    }

    #[test]
    fn locked_links_are_right_where_they_are_locked() {
        let found = ["payload", "locked_links"];
        assert_eq!(verdict(&["payload"], true, &found, true), Verdict::Right);
        assert_eq!(verdict(&["payload"], false, &found, true), Verdict::Partly);
        // Not listed, they need not be found.
        assert_eq!(
            verdict(&["payload"], true, &["payload"], true),
            Verdict::Right
        );
        assert_eq!(verdict(&[], true, &["locked_links"], true), Verdict::Right);
        assert_eq!(verdict(&[], true, &[], true), Verdict::Right);
        assert_eq!(verdict(&[], false, &["locked_links"], true), Verdict::Wrong);
        // Nor are they a find where something else is listed.
        assert_eq!(
            verdict(&["payload"], true, &["locked_links"], true),
            Verdict::Missed
        );
    }

    #[test]
    fn listed_locked_links_are_to_be_found() {
        let listed = ["locked_links"];
        assert_eq!(verdict(&listed, true, &listed, true), Verdict::Right);
        assert_eq!(verdict(&listed, true, &[], true), Verdict::Missed);
        let with_another = ["locked_links", "payload"];
        assert_eq!(verdict(&listed, true, &with_another, true), Verdict::Partly);
        assert_eq!(verdict(&listed, true, &["payload"], true), Verdict::Wrong);
    }

    #[test]
    fn unexplained_is_a_find_where_the_library_lacks_an_effect() {
        assert_eq!(
            verdict(&["unknown"], false, &["unknown"], true),
            Verdict::Right
        );
        assert_eq!(verdict(&["unknown"], false, &[], true), Verdict::Missed);
        assert_eq!(
            verdict(&["unknown"], false, &["payload"], true),
            Verdict::Wrong
        );
        let both = ["unknown", "payload"];
        assert_eq!(verdict(&["unknown"], false, &both, true), Verdict::Partly);
        assert_eq!(verdict(&["payload"], false, &both, true), Verdict::Partly);
        assert_eq!(verdict(&[], false, &["unknown"], true), Verdict::Wrong);
    }

    #[test]
    fn kind_and_place_are_told_apart() {
        let truth = |parameters: serde_json::Value| TrueEffect {
            kind: "stuck_joint".into(),
            parameters: serde_json::from_value(parameters).unwrap(),
        };
        let found = |kind: &str, leg, joint| FoundEffect {
            kind: kind.into(),
            parameters: [
                ("leg".to_string(), Reported::Number(leg)),
                ("joint".to_string(), Reported::Number(joint)),
            ]
            .into(),
            probability: 1.0,
        };
        let stuck = truth(json!({"leg": 3, "joint": 2, "angle_rad": 0.1}));
        let place = |found: FoundEffect| {
            let place = PlaceScore::new(&stuck, &[found]).unwrap();
            [place.kind_found, place.leg_right, place.place_right]
        };
        assert_eq!(place(found("stuck_joint", 3, 2)), [true, true, true]);
        assert_eq!(place(found("stuck_joint", 3, 1)), [true, true, false]);
        assert_eq!(place(found("stuck_joint", 1, 2)), [true, false, false]);
        assert_eq!(place(found("joint_offset", 3, 2)), [false, false, false]);
        assert_eq!(PlaceScore::new(&truth(json!({"mass_kg": 0.1})), &[]), None);
    }
}
