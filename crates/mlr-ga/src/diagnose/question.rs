//! What a log leaves open.

use std::collections::{BTreeMap, BTreeSet};

use mlr_model::{LostLinks, Morphology, Robot};
use mlr_residual::walk::Reported;
use serde::Serialize;

use crate::{
    Identification,
    answer_json::{AlternativeJson, AnswerJson, AnswerJsonError, Question, answer_of_json},
};

/// What a log leaves open.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenQuestion {
    /// The robots in question, most probable first.
    pub robots: Vec<OpenRobot>,
}

/// One of the robots in question: what is left of it, and what else is wrong with it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OpenRobot {
    /// Which links are left.
    pub morphology: Morphology,
    /// Its probability among those in question.
    pub probability: f64,
    /// Probability that its lost links are locked and not gone; 0 where it lost none.
    pub locked_probability: f64,
    /// What else is wrong with it. Of an identification, nothing.
    pub effects: Vec<OpenEffect>,
}

/// An effect in question, as an explanation reports it, or as its prior expects it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OpenEffect {
    /// What it is.
    pub kind: String,
    /// Its parameters, each in the unit of its name. None where it is asked about whatever its size.
    pub parameters: BTreeMap<String, Reported>,
}

impl OpenEffect {
    /// Whether it may be anywhere on the robot and of any size that its prior has.
    pub fn is_of_any_size(&self) -> bool {
        self.parameters.is_empty()
    }
}

/// A robot whose lost links are gone or locked.
#[derive(Debug, Clone, PartialEq)]
pub struct Hypothesis<'q> {
    /// The robot.
    pub robot: &'q OpenRobot,
    /// What its lost links have become.
    pub lost_links: LostLinks,
    /// All hypotheses sum to one.
    pub probability: f64,
}

/// A log whose robot is known better than this leaves nothing to tell apart.
const SURE_NATS: f64 = 0.05;
/// Less probable robots are not asked about.
const LEAST_PROBABILITY: f64 = 0.01;

impl OpenQuestion {
    /// What an identification leaves open: the morphologies of at least one percent.
    pub fn of(answer: &Identification) -> Self {
        let open =
            |morphology: &Morphology, probability, locked_probability: Option<f64>| OpenRobot {
                morphology: morphology.clone(),
                probability,
                locked_probability: locked_probability.unwrap_or(0.0),
                effects: Vec::new(),
            };
        let likeliest = answer.probability.max(f64::MIN_POSITIVE);
        let best = open(&answer.morphology, likeliest, answer.locked_probability);
        let others = answer.alternatives.iter().map(|other| {
            open(
                &other.morphology,
                other.probability,
                other.locked_probability,
            )
        });
        let others = others.filter(|other| other.probability >= LEAST_PROBABILITY);
        Self::among(std::iter::once(best).chain(others).collect())
    }

    /// What an explanation of `robot` leaves open, as `explain --json` prints it: its hypotheses of at
    /// least one percent that are complete, with their effects.
    ///
    /// # Errors
    /// [`AnswerJsonError`] when the text is no explanation, or of another robot.
    pub fn of_explanation(text: &str, robot: &Robot) -> Result<Self, AnswerJsonError> {
        let answer: AnswerJson = answer_of_json(text, robot, Question::Explanation)?;
        let known = answer.alternatives.into_iter();
        let known = known.filter(|one| !one.unknown && one.probability >= LEAST_PROBABILITY);
        Ok(Self::among(known.map(OpenRobot::from).collect()))
    }

    /// The same asked about these kinds of effects as well, wherever they are and whatever their size: each alone
    /// on what is left of the most probable robot, and as probable as that one. A kind that is in question already
    /// stays as it is.
    #[must_use]
    pub fn asking(self, kinds: &[String]) -> Self {
        let Some(best) = self.robots.first().cloned() else {
            return self;
        };
        let is_asked = |kind: &String| {
            let mut open = self.robots.iter().flat_map(|one| &one.effects);
            !open.any(|effect| effect.kind == *kind)
        };
        let kinds: BTreeSet<&String> = kinds.iter().collect();
        let asked = kinds.into_iter().filter(|kind| is_asked(kind));
        let asked = asked.map(|kind| OpenRobot {
            effects: vec![OpenEffect {
                kind: kind.clone(),
                parameters: BTreeMap::new(),
            }],
            ..best.clone()
        });
        let asked: Vec<OpenRobot> = asked.collect();
        Self::among(self.robots.into_iter().chain(asked).collect())
    }

    /// One of these robots is the right one.
    fn among(mut robots: Vec<OpenRobot>) -> Self {
        robots.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        let sum: f64 = robots.iter().map(|one| one.probability).sum();
        for one in &mut robots {
            one.probability /= sum;
        }
        Self { robots }
    }

    /// Entropy of the robot and of what its lost links have become.
    pub fn entropy_nats(&self) -> f64 {
        entropy_nats(self.hypotheses().iter().map(|one| one.probability))
    }

    /// The robots with what their lost links may be, as far as that has at least one percent.
    pub fn hypotheses(&self) -> Vec<Hypothesis<'_>> {
        let each = self.robots.iter().flat_map(|one| {
            let cases = LostLinks::with_probabilities(one.locked_probability);
            cases.map(|(lost_links, share)| Hypothesis {
                robot: one,
                lost_links,
                probability: share * one.probability,
            })
        });
        let mut kept: Vec<_> = each
            .filter(|one| one.probability >= LEAST_PROBABILITY)
            .collect();
        let sum: f64 = kept.iter().map(|one| one.probability).sum();
        for one in &mut kept {
            one.probability /= sum;
        }
        kept
    }

    /// Whether the robot is known: what its lost links have become is not asked for its own sake.
    pub fn is_sure(&self) -> bool {
        let of_robots = self.robots.iter().map(|one| one.probability);
        self.hypotheses().len() < 2 || entropy_nats(of_robots) < SURE_NATS
    }

    /// Whether effects are in question.
    pub fn is_of_effects(&self) -> bool {
        self.robots.iter().any(|one| !one.effects.is_empty())
    }

    /// Whether effects of any size are in question.
    pub fn is_of_any_size(&self) -> bool {
        let mut effects = self.robots.iter().flat_map(|one| &one.effects);
        effects.any(OpenEffect::is_of_any_size)
    }

    /// The legs, from 0, of which not the same links are left in all robots.
    pub fn legs_in_doubt(&self) -> Vec<usize> {
        let Some(best) = self.robots.first() else {
            return Vec::new();
        };
        let legs = 0..best.morphology.legs();
        let in_doubt = |leg: &usize| {
            let mut others = self.robots.iter();
            let remaining = best.morphology.remaining(*leg);
            others.any(|other| other.morphology.remaining(*leg) != remaining)
        };
        legs.filter(in_doubt).collect()
    }
}

impl From<AlternativeJson> for OpenRobot {
    fn from(found: AlternativeJson) -> Self {
        Self {
            morphology: found.morphology.clone(),
            probability: found.probability,
            locked_probability: f64::from(u8::from(found.locked_links)),
            effects: found
                .other_effects()
                .map(|effect| OpenEffect {
                    kind: effect.kind,
                    parameters: effect.parameters,
                })
                .collect(),
        }
    }
}

pub(super) fn entropy_nats(probabilities: impl Iterator<Item = f64>) -> f64 {
    let positive = probabilities.filter(|p| *p > 0.0);
    0.0 - positive.map(|p| p * p.ln()).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use mlr_model::Robot;

    use super::*;

    fn question(each: &[(&str, f64, f64)]) -> OpenQuestion {
        let layout = Robot::jethexa().layout();
        let open = each.iter().map(|(text, probability, locked)| OpenRobot {
            morphology: Morphology::parse(text, &layout).unwrap(),
            probability: *probability,
            locked_probability: *locked,
            effects: Vec::new(),
        });
        OpenQuestion {
            robots: open.collect(),
        }
    }

    #[test]
    fn legs_in_doubt_are_those_that_morphologies_differ_by() {
        let open = question(&[
            ("111 111 110 000 111 111", 0.5, 0.0),
            ("111 111 100 000 111 111", 0.3, 0.0),
            ("111 111 100 000 111 110", 0.2, 0.0),
        ]);
        assert_eq!(open.legs_in_doubt(), [2, 5]);
        assert!(!open.is_sure());
    }

    #[test]
    fn lost_links_are_gone_or_locked_as_far_as_that_is_in_question() {
        let open = question(&[
            ("111 111 110 111 111 111", 0.7, 0.5),
            ("111 111 100 111 111 111", 0.3, 0.001),
        ]);
        let hypotheses = open.hypotheses();
        let kinds: Vec<_> = hypotheses.iter().map(|one| one.lost_links).collect();
        assert_eq!(
            kinds,
            [LostLinks::Absent, LostLinks::Locked, LostLinks::Absent]
        );
        let sum: f64 = hypotheses.iter().map(|one| one.probability).sum();
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
        // What they have become is one more thing not to know, but no reason to ask by itself.
        let known = question(&[("111 111 110 111 111 111", 1.0, 0.5)]);
        assert!((known.entropy_nats() - 2.0_f64.ln()).abs() < 1e-12);
        assert!(known.is_sure());
    }

    #[test]
    fn an_explanation_leaves_its_hypotheses_open() {
        let whole = "[[1,1,1],[1,1,1],[1,1,1],[1,1,1],[1,1,1],[1,1,1]]";
        let hypothesis = |effects: &str, unknown: bool, probability: f64| {
            format!(
                r#"{{"morphology":{whole},"locked_links":false,"effects":[{effects}],
                    "unknown":{unknown},"probability":{probability}}}"#
            )
        };
        let slope = r#"{"kind":"slope","parameters":{"angle_deg":3.0,"uphill_deg":40.0}}"#;
        let tilt = r#"{"kind":"imu_misalignment","parameters":{"roll_deg":2.0,"pitch_deg":-2.3}}"#;
        let each = [
            hypothesis(tilt, false, 0.3),
            hypothesis(slope, false, 0.6),
            hypothesis(slope, true, 0.09),
            hypothesis("", false, 0.002),
        ];
        let text = format!(
            r#"{{"schema":"mlr.explanation/1","morphology":{whole},"alternatives":[{}]}}"#,
            each.join(",")
        );
        let question = OpenQuestion::of_explanation(&text, &Robot::jethexa()).unwrap();
        let kinds: Vec<_> = question
            .robots
            .iter()
            .map(|one| &*one.effects[0].kind)
            .collect();
        assert_eq!(kinds, ["slope", "imu_misalignment"]);
        assert!((question.robots[0].probability - 2.0 / 3.0).abs() < 1e-12);
        assert!(question.is_of_effects() && !question.is_sure());
        assert!(question.legs_in_doubt().is_empty());
        // What else is asked about is as probable as the most probable one, and once.
        let asked = question.asking(&["payload", "slope", "payload"].map(String::from));
        let of = |kind: &str| {
            let mut robots = asked.robots.iter();
            robots.find(|one| one.effects[0].kind == kind).unwrap()
        };
        assert_eq!(asked.robots.len(), 3);
        assert!((of("payload").probability - of("slope").probability).abs() < 1e-12);
        assert!(of("payload").effects[0].is_of_any_size());
        assert!(!of("slope").effects[0].is_of_any_size() && asked.is_of_any_size());
    }
}
