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

/// The morphologies of an identification, with their probabilities.
pub fn diagnosis_of_identification(found: &Identification) -> Diagnosis {
    let others = found.alternatives.iter();
    of_morphologies(
        found.fit.lost_links,
        found.morphology.clone(),
        found.probability,
        others.map(|one| (one.morphology.clone(), one.probability)),
    )
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
            of_morphologies(
                lost_links,
                answer.morphology,
                answer.probability,
                others.map(|one| (one.morphology, one.probability)),
            )
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

fn of_morphologies(
    lost_links: LostLinks,
    best: Morphology,
    probability: f64,
    others: impl Iterator<Item = (Morphology, f64)>,
) -> Diagnosis {
    let of = |morphology| WhatIsLeft {
        lost_links,
        ..WhatIsLeft::of(morphology)
    };
    let others = others.map(|(morphology, probability)| (of(morphology), probability));
    Diagnosis::new(of(best), probability, others.collect())
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
