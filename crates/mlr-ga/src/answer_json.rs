//! Answers of `identify` and `explain` as JSON, read again.

use std::collections::BTreeMap;

use mlr_model::{LostLinks, Morphology, Robot};
use mlr_residual::walk::{LOCKED_LINKS, Reported};
use serde::{Deserialize, de::DeserializeOwned};
use serde_json::Value;
use thiserror::Error;

/// An answer as far as it says what is left of a robot.
#[derive(Debug, Deserialize)]
pub(crate) struct AnswerJson {
    pub(crate) morphology: Morphology,
    #[serde(default)]
    pub(crate) probability: f64,
    #[serde(default)]
    pub(crate) locked_probability: Option<f64>,
    pub(crate) fit: Option<FitJson>,
    #[serde(default)]
    pub(crate) effects: Vec<EffectJson>,
    #[serde(default)]
    pub(crate) alternatives: Vec<AlternativeJson>,
    #[serde(default)]
    pub(crate) implausible: bool,
    #[serde(default)]
    pub(crate) unexplained: bool,
}

#[derive(Debug, Deserialize)]
pub(crate) struct FitJson {
    pub(crate) lost_links: LostLinks,
}

#[derive(Debug, Deserialize)]
pub(crate) struct AlternativeJson {
    pub(crate) morphology: Morphology,
    pub(crate) probability: f64,
    #[serde(default)]
    pub(crate) locked_probability: Option<f64>,
    #[serde(default)]
    pub(crate) locked_links: bool,
    #[serde(default)]
    pub(crate) unknown: bool,
    #[serde(default)]
    pub(crate) effects: Vec<EffectJson>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct EffectJson {
    pub(crate) kind: String,
    pub(crate) parameters: BTreeMap<String, Reported>,
}

impl AlternativeJson {
    /// Its effects but for lost links that hang on, which `locked_links` says.
    pub(crate) fn other_effects(self) -> impl Iterator<Item = EffectJson> {
        let effects = self.effects.into_iter();
        effects.filter(|effect| effect.kind != LOCKED_LINKS)
    }
}

/// The question that an answer is to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Question {
    /// `mlr.identification/1`.
    Identification,
    /// `mlr.explanation/1`.
    Explanation,
}

/// What is wrong with an answer's JSON.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum AnswerJsonError {
    /// It is no JSON, or of another form.
    #[error("{0}, expected an answer as mlr-ga identify --json or explain --json prints it")]
    Form(#[from] serde_json::Error),
    /// It is another kind of answer.
    #[error(
        "schema: {0} is not valid, expected an answer of identify or explain \
         (\"mlr.identification/1\" or \"mlr.explanation/1\"), as mlr-ga prints it with --json"
    )]
    Schema(String),
    /// It answers another question.
    #[error(
        "the answer is one of {found}, expected one of {expected}, as mlr-ga {expected} --json prints it"
    )]
    OtherQuestion {
        /// The command that it is of.
        found: &'static str,
        /// The command that one is needed of.
        expected: &'static str,
    },
    /// It is of a robot with other legs.
    #[error(
        "the answer is of a robot with {found}, expected {expected} as {robot} has them: name the \
         --robot with which it was found"
    )]
    OtherRobot {
        /// Links of the legs of the answer.
        found: String,
        /// Links of the legs of the robot.
        expected: String,
        /// The robot's name.
        robot: String,
    },
}

impl AnswerJsonError {
    /// Refuses a morphology that is none of this robot's.
    pub(crate) fn check_robot(found: &Morphology, robot: &Robot) -> Result<(), Self> {
        if found.layout() == robot.layout() {
            return Ok(());
        }
        let links = |links: Vec<usize>| {
            let links: Vec<String> = links.iter().map(usize::to_string).collect();
            format!("legs of {} links", links.join(", "))
        };
        Err(Self::OtherRobot {
            found: links((0..found.legs()).map(|leg| found.links(leg)).collect()),
            expected: links(robot.legs().iter().map(|leg| leg.links.len()).collect()),
            robot: robot.name().into(),
        })
    }
}

impl Question {
    /// The command that asks it.
    fn command(self) -> &'static str {
        match self {
            Self::Identification => "identify",
            Self::Explanation => "explain",
        }
    }
}

/// Reads the answer of a command, or an event of the daemon with one, to a `question` about `robot`,
/// as far as `Answer` needs it.
///
/// # Errors
/// [`AnswerJsonError`] when the text is no such answer, or of another robot.
pub fn answer_of_json<Answer: DeserializeOwned>(
    text: &str,
    robot: &Robot,
    question: Question,
) -> Result<Answer, AnswerJsonError> {
    let (found, answer) = checked(text, robot)?;
    if found != question {
        return Err(AnswerJsonError::OtherQuestion {
            found: found.command(),
            expected: question.command(),
        });
    }
    Ok(serde_json::from_value(answer)?)
}

impl AnswerJson {
    /// Reads the answer of a command, or an event of the daemon with one, found with `robot`.
    pub(crate) fn read(text: &str, robot: &Robot) -> Result<(Question, Self), AnswerJsonError> {
        let (question, answer) = checked(text, robot)?;
        Ok((question, serde_json::from_value(answer)?))
    }
}

/// What a command printed with --json, or what an event of the daemon carries of it.
pub(crate) fn printed_object(text: &str) -> serde_json::Result<Value> {
    let mut value: Value = serde_json::from_str(text)?;
    Ok(match value.get_mut("result") {
        Some(result) => result.take(),
        None => value,
    })
}

/// An answer about this robot, and to which question.
fn checked(text: &str, robot: &Robot) -> Result<(Question, Value), AnswerJsonError> {
    let value = printed_object(text)?;
    let question = match &value["schema"] {
        Value::String(schema) if schema == "mlr.identification/1" => Question::Identification,
        Value::String(schema) if schema == "mlr.explanation/1" => Question::Explanation,
        Value::Null => return Err(AnswerJsonError::Schema("nothing".into())),
        found => return Err(AnswerJsonError::Schema(found.to_string())),
    };
    let answer = AnswerJson::deserialize(&value)?;
    let others = answer.alternatives.iter().map(|one| &one.morphology);
    for found in std::iter::once(&answer.morphology).chain(others) {
        AnswerJsonError::check_robot(found, robot)?;
    }
    Ok((question, value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_is_read_if_it_is_to_the_question() {
        #[derive(Debug, Deserialize)]
        struct Seed {
            seed: u64,
        }
        let robot = Robot::jethexa();
        let read = |text: &str, question| answer_of_json::<Seed>(text, &robot, question);
        let whole = "[[1,1,1],[1,1,1],[1,1,1],[1,1,1],[1,1,1],[1,1,1]]";
        let answer =
            format!(r#"{{"schema":"mlr.identification/1","morphology":{whole},"seed":7}}"#);
        let event = format!(r#"{{"event":"identified","result":{answer}}}"#);
        for text in [&answer, &event] {
            assert_eq!(read(text, Question::Identification).unwrap().seed, 7);
        }
        let error = read(&answer, Question::Explanation)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("is one of identify, expected one of explain"),
            "{error}"
        );
        let lacks = answer.replace("seed", "sown");
        let error = read(&lacks, Question::Identification)
            .unwrap_err()
            .to_string();
        assert!(error.contains("`seed`"), "{error}");
    }
}
