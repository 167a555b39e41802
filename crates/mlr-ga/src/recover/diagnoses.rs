//! What answers say of what is left of a robot.

use std::collections::BTreeMap;

use mlr_model::{Gait, LostLinks, Morphology, Robot, SimulationSettings};
use mlr_recover::{Diagnosis, WhatIsLeft};
use mlr_residual::{
    walk::{Reported, WalkExplanation, WalkModel},
    walk_effects::apply_reported,
};

use crate::{
    Identification,
    answer_json::{AnswerJson, AnswerJsonError, Question},
};

/// The morphologies of an identification, their lost links gone or locked, with their probabilities.
pub fn diagnosis_of_identification(found: &Identification) -> Diagnosis {
    let best = Found {
        morphology: found.morphology.clone(),
        probability: found.probability,
        locked_probability: found.locked_probability,
    };
    let others = found.alternatives.iter().map(|one| Found {
        morphology: one.morphology.clone(),
        probability: one.probability,
        locked_probability: one.locked_probability,
    });
    of_morphologies(found.fit.lost_links, best, others)
}

/// The hypotheses of an explanation, with their probabilities: of their effects, those that stay with
/// the robot's legs and what it carries.
pub fn diagnosis_of_explanation(robot: &Robot, found: &WalkExplanation) -> Diagnosis {
    let cases = found.alternatives.iter().map(|one| {
        let effects = one.effects.iter();
        let effects = effects.map(|effect| (effect.kind.as_str(), &effect.parameters));
        let left = with_effects(robot, one.morphology.clone(), one.locked_links, effects);
        (left, one.probability)
    });
    Diagnosis::new(
        WhatIsLeft::of(found.morphology.clone()),
        0.0,
        cases.collect(),
    )
}

/// What an answer in JSON says: of identify or explain, or an event of the daemon with one.
///
/// # Errors
/// [`AnswerJsonError`].
pub fn diagnosis_of_json(robot: &Robot, text: &str) -> Result<Diagnosis, AnswerJsonError> {
    let (question, answer) = AnswerJson::read(text, robot)?;
    let others = answer.alternatives.into_iter();
    Ok(match question {
        Question::Identification => {
            let lost_links = answer
                .fit
                .map_or_else(Default::default, |fit| fit.lost_links);
            let best = Found {
                morphology: answer.morphology,
                probability: answer.probability,
                locked_probability: answer.locked_probability,
            };
            let others = others.map(|one| Found {
                morphology: one.morphology,
                probability: one.probability,
                locked_probability: one.locked_probability,
            });
            of_morphologies(lost_links, best, others)
        }
        Question::Explanation => {
            let cases = others.map(|one| {
                let effects = one.effects.iter();
                let effects = effects.map(|effect| (effect.kind.as_str(), &effect.parameters));
                let left = with_effects(robot, one.morphology, one.locked_links, effects);
                (left, one.probability)
            });
            Diagnosis::new(WhatIsLeft::of(answer.morphology), 0.0, cases.collect())
        }
    })
}

/// A morphology of an identification.
struct Found {
    morphology: Morphology,
    probability: f64,
    /// Where the answer says it.
    locked_probability: Option<f64>,
}

impl Found {
    /// Its lost links gone or locked, with the probability of each: as `usual` where the answer does
    /// not say.
    fn cases(self, usual: LostLinks) -> [(WhatIsLeft, f64); 2] {
        let locked = self.locked_probability.unwrap_or(match usual {
            LostLinks::Absent => 0.0,
            LostLinks::Locked => 1.0,
        });
        LostLinks::with_probabilities(locked).map(|(lost_links, share)| {
            let left = WhatIsLeft {
                lost_links,
                ..WhatIsLeft::of(self.morphology.clone())
            };
            (left, share * self.probability)
        })
    }
}

/// Without any probability, the best one's more probable case stands for all.
fn of_morphologies(
    lost_links: LostLinks,
    best: Found,
    others: impl Iterator<Item = Found>,
) -> Diagnosis {
    let [gone, locked] = best.cases(lost_links);
    let ((most_probable, weight), less) = match gone.1 >= locked.1 {
        true => (gone, locked),
        false => (locked, gone),
    };
    let others = others.flat_map(|one| one.cases(lost_links));
    let others = std::iter::once(less).chain(others).collect();
    Diagnosis::new(most_probable, weight, others)
}

fn with_effects<'e>(
    robot: &Robot,
    morphology: Morphology,
    locked_links: bool,
    effects: impl Iterator<Item = (&'e str, &'e BTreeMap<String, Reported>)>,
) -> WhatIsLeft {
    let simulation = SimulationSettings {
        lost_links: match locked_links {
            true => LostLinks::Locked,
            false => LostLinks::default(),
        },
        ..SimulationSettings::default()
    };
    // What effects do to a robot does not depend on its gait.
    let mut model = WalkModel::nominal(robot.clone(), Gait::tripod(), simulation);
    for (kind, parameters) in effects {
        // An effect that lacks a parameter changes nothing, like those that are none of the robot's.
        let _ = apply_reported(kind, parameters, &mut model);
    }
    WhatIsLeft {
        lost_links: model.simulation.lost_links,
        faults: model.simulation.faults,
        payload: model.simulation.payload,
        ..WhatIsLeft::of(morphology)
    }
}

#[cfg(test)]
mod tests {
    use mlr_model::Fault;

    use super::*;

    #[test]
    fn an_explanation_says_what_stays_with_the_robot() {
        let text = r#"{"event": "explained", "result": {"schema": "mlr.explanation/1",
            "morphology": [[1,1,1],[1,1,1],[0,0,0],[1,1,1],[1,1,1],[1,1,1]],
            "alternatives": [
              {"morphology": [[1,1,1],[1,1,1],[0,0,0],[1,1,1],[1,1,1],[1,1,1]], "locked_links": true,
               "effects": [{"kind": "weak_leg", "parameters": {"leg": 2, "gain": 0.4}},
                           {"kind": "slope", "parameters": {"angle_deg": 3.0, "uphill_deg": 0.0}},
                           {"kind": "payload", "parameters": {"mass_kg": 0.3, "x_m": 0.05, "y_m": -0.02}}],
               "unknown": false, "probability": 0.6},
              {"morphology": [[1,1,1],[1,1,1],[1,0,0],[1,1,1],[1,1,1],[1,1,1]], "locked_links": false,
               "effects": [], "unknown": false, "probability": 0.2}]}}"#;
        let diagnosis = diagnosis_of_json(&Robot::jethexa(), text).unwrap();
        assert_eq!(diagnosis.cases(), 2);
        let left = diagnosis.most_probable();
        assert_eq!(left.lost_links, LostLinks::Locked);
        assert_eq!(left.faults, [Fault::WeakLeg { leg: 2, gain: 0.4 }]);
        assert_eq!(left.payload.map(|load| load.mass_kg), Some(0.3));
        assert!(left.can_walk(1) && !left.can_walk(2));
    }

    #[test]
    fn lost_links_of_an_identification_are_gone_or_locked_as_it_says() {
        let text = r#"{"schema": "mlr.identification/1", "fit": {"lost_links": "locked"},
            "morphology": [[1,1,1],[1,1,1],[0,0,0],[1,1,1],[1,1,1],[1,1,1]], "probability": 0.6,
            "locked_probability": 0.25, "alternatives": [
              {"morphology": [[1,1,1],[1,1,1],[1,0,0],[1,1,1],[1,1,1],[1,1,1]], "probability": 0.4}]}"#;
        let diagnosis = diagnosis_of_json(&Robot::jethexa(), text).unwrap();
        // The second is as the fit says, whatever else it could be.
        assert_eq!(diagnosis.cases(), 3);
        assert_eq!(diagnosis.most_probable().lost_links, LostLinks::Absent);
        let locked = [0.0, 0.46, 0.9].map(|share| diagnosis.at(share).lost_links);
        assert_eq!(
            locked,
            [LostLinks::Absent, LostLinks::Locked, LostLinks::Locked]
        );
    }

    #[test]
    fn what_is_no_answer_about_this_robot_is_refused() {
        let message = |text: &str| {
            let refused = diagnosis_of_json(&Robot::jethexa(), text);
            refused.unwrap_err().to_string()
        };
        assert!(message("t_s,roll_rad").contains("expected an answer"));
        let other = r#"{"schema": "mlr.identification/1", "morphology": [[1,1],[0,0]]}"#;
        assert!(message(other).contains("Hiwonder"));
        let question = r#"{"schema": "mlr.probe/1",
            "morphology": [[1,1,1],[1,1,1],[0,0,0],[1,1,1],[1,1,1],[1,1,1]]}"#;
        assert!(message(question).contains("mlr.probe/1"));
    }
}
