//! An explanation of another log of the same robot.

use mlr_model::Robot;
use mlr_residual::walk::EarlierEffects;

use crate::answer_json::{AnswerJson, AnswerJsonError, Question, answer_of_json};

/// The effects of `robot` by an explanation, as `explain --json` prints it.
///
/// # Errors
/// [`AnswerJsonError`] when the text is no explanation, or of another robot.
pub fn earlier_effects_of_json(
    text: &str,
    robot: &Robot,
) -> Result<EarlierEffects, AnswerJsonError> {
    let answer: AnswerJson = answer_of_json(text, robot, Question::Explanation)?;
    let hypotheses = answer.alternatives.into_iter().map(|one| {
        let probability = one.probability;
        let kinds = one.other_effects().map(|effect| effect.kind);
        (kinds.collect(), probability)
    });
    Ok(EarlierEffects::new(hypotheses))
}
