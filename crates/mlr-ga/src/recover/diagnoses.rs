//! What answers say of what is left of a robot.

use std::collections::BTreeMap;

use mlr_model::{Fault, LostLinks, Morphology, Payload, Robot};
use mlr_recover::{Diagnosis, WhatIsLeft};
use mlr_residual::{
    walk::{Reported, WalkExplanation},
    walk_effects::LOAD_HEIGHT_M,
};
use serde::Deserialize;
use serde_json::Value;
use thiserror::Error;

use crate::Identification;

/// Why a file gives no diagnosis.
#[derive(Debug, Error)]
pub enum AnswerFileError {
    /// It is no JSON of the expected form.
    #[error("expected an answer of identify or explain as JSON")]
    Syntax(#[from] serde_json::Error),
    /// It is about another robot.
    #[error("the answer is about a robot with other legs, expected one about {0}")]
    OtherRobot(String),
    /// It is an answer to another question.
    #[error("schema {0:?}, expected mlr.identification/1 or mlr.explanation/1")]
    Schema(String),
}

/// An answer as far as it says what is left. Events of the daemon hold it as `result`.
#[derive(Deserialize)]
struct Answer {
    schema: String,
    morphology: Morphology,
    #[serde(default)]
    probability: f64,
    fit: Option<Fit>,
    #[serde(default)]
    alternatives: Vec<Alternative>,
}

#[derive(Deserialize)]
struct Fit {
    lost_links: LostLinks,
}

#[derive(Deserialize)]
struct Alternative {
    morphology: Morphology,
    probability: f64,
    #[serde(default)]
    locked_links: bool,
    #[serde(default)]
    effects: Vec<Effect>,
}

#[derive(Deserialize)]
struct Effect {
    kind: String,
    parameters: BTreeMap<String, Reported>,
}

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
/// [`AnswerFileError`].
pub fn diagnosis_of_json(robot: &Robot, text: &str) -> Result<Diagnosis, AnswerFileError> {
    let mut value: Value = serde_json::from_str(text)?;
    if let Some(result) = value.get_mut("result") {
        value = result.take();
    }
    let answer: Answer = serde_json::from_value(value)?;
    let layout = robot.layout();
    let others = answer.alternatives.iter().map(|one| &one.morphology);
    if std::iter::once(&answer.morphology)
        .chain(others)
        .any(|one| one.layout() != layout)
    {
        return Err(AnswerFileError::OtherRobot(robot.name().into()));
    }
    match answer.schema.as_str() {
        "mlr.identification/1" => {
            let lost_links = answer
                .fit
                .map_or(LostLinks::default(), |fit| fit.lost_links);
            let others = answer.alternatives.into_iter();
            Ok(of_morphologies(
                lost_links,
                answer.morphology,
                answer.probability,
                others.map(|one| (one.morphology, one.probability)),
            ))
        }
        "mlr.explanation/1" => {
            let cases = answer.alternatives.into_iter().map(|one| {
                let effects = one.effects.iter();
                let effects = effects.map(|effect| (effect.kind.as_str(), &effect.parameters));
                let left = with_effects(robot, one.morphology, one.locked_links, effects);
                (left, one.probability)
            });
            Ok(Diagnosis::new(
                WhatIsLeft::of(answer.morphology),
                0.0,
                cases.collect(),
            ))
        }
        _ => Err(AnswerFileError::Schema(answer.schema)),
    }
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
    let mut left = WhatIsLeft::of(morphology);
    if locked_links {
        left.lost_links = LostLinks::Locked;
    }
    for (kind, parameters) in effects {
        let quantity = |name: &str| match parameters.get(name) {
            Some(Reported::Quantity(value)) => *value,
            _ => 0.0,
        };
        match kind {
            "payload" => {
                let deck_m = robot.body().size_m.z / 2.0;
                left.payload = Some(Payload {
                    mass_kg: quantity("mass_kg"),
                    position_m: [quantity("x_m"), quantity("y_m"), deck_m + LOAD_HEIGHT_M],
                });
            }
            // Where the robot was, and not what it is.
            "external_force" => {}
            _ => left.faults.extend(fault(kind, parameters)),
        }
    }
    left
}

/// The fault of the model that an effect is, if it is one.
fn fault(kind: &str, parameters: &BTreeMap<String, Reported>) -> Option<Fault> {
    let mut value = serde_json::to_value(parameters).ok()?;
    value.as_object_mut()?.insert("kind".into(), kind.into());
    serde_json::from_value(value).ok()
}

#[cfg(test)]
mod tests {
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
