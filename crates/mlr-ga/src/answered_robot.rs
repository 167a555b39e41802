//! The robot that an answer describes.

use mlr_filter::SettingError;
use mlr_model::{Gait, ModelError, Morphology, Robot, SimulationSettings};
use mlr_residual::{walk::WalkModel, walk_effects::apply_reported};
use thiserror::Error;

use crate::answer_json::{AnswerJson, AnswerJsonError};

/// What is left of a robot, by an answer of `mlr-ga identify` or `mlr-ga explain`.
#[derive(Debug, Clone, PartialEq)]
pub struct AnsweredRobot {
    /// The robot as described, with what the answer says of its servos.
    pub robot: Robot,
    /// Which links are left.
    pub morphology: Morphology,
    /// Lost links, payload, faults, and the friction of the ground.
    pub settings: SimulationSettings,
    /// Kinds of effects of the answer that are none of the robot's.
    pub left_out: Vec<String>,
    /// Whether the answer itself says that it explains nothing.
    pub doubtful: bool,
}

/// What is wrong with an answer's JSON.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum AnsweredRobotError {
    /// It is no answer about this robot.
    #[error(transparent)]
    Answer(#[from] AnswerJsonError),
    /// An effect makes no sense.
    #[error(transparent)]
    Effect(#[from] SettingError),
    /// A servo with the effects makes no sense.
    #[error(transparent)]
    Model(#[from] ModelError),
}

impl AnsweredRobot {
    /// Reads the answer of a command, or an event of the daemon with one. The answer was found with
    /// `robot`.
    ///
    /// # Errors
    /// [`AnsweredRobotError`] when the text is no such answer, or of another robot.
    pub fn from_json(text: &str, robot: &Robot) -> Result<Self, AnsweredRobotError> {
        let (_, answer) = AnswerJson::read(text, robot)?;
        let settings = SimulationSettings {
            lost_links: answer
                .fit
                .map_or_else(Default::default, |fit| fit.lost_links),
            ..SimulationSettings::default()
        };
        // What effects do to a robot does not depend on its gait.
        let mut model = WalkModel::nominal(robot.clone(), Gait::tripod(), settings);
        let mut left_out = Vec::new();
        for (index, effect) in answer.effects.into_iter().enumerate() {
            let under = |error: SettingError| error.under(&format!("effects[{index}]"));
            let parameters = &effect.parameters;
            if !apply_reported(&effect.kind, parameters, &mut model).map_err(under)? {
                left_out.push(effect.kind);
            }
        }
        model.simulation.check_on(robot)?;
        Ok(Self {
            robot: model.robot.with_servo(model.servo)?,
            morphology: answer.morphology,
            settings: model.simulation,
            left_out,
            doubtful: answer.implausible || answer.unexplained,
        })
    }
}

#[cfg(test)]
mod tests {
    use mlr_model::{Fault, LostLinks};

    use super::*;

    const MORPHOLOGY: &str = "[[1,1,1],[1,1,1],[0,0,0],[1,0,0],[1,1,1],[1,1,1]]";

    fn read(text: &str) -> Result<AnsweredRobot, AnsweredRobotError> {
        AnsweredRobot::from_json(text, &Robot::jethexa())
    }

    #[test]
    fn an_identification_says_what_is_left_and_whether_the_rest_hangs_on() {
        let text = format!(
            r#"{{"schema":"mlr.identification/1","morphology":{MORPHOLOGY},"fit":{{"lost_links":"locked","friction":2}}}}"#
        );
        let found = read(&text).unwrap();
        assert_eq!(found.morphology.damaged_legs(), [3, 4]);
        assert_eq!(found.settings.lost_links, LostLinks::Locked);
        assert_eq!(found.robot, Robot::jethexa());
        // The same in an event of the daemon.
        let event = format!(r#"{{"event":"identified","result":{text}}}"#);
        assert_eq!(read(&event).unwrap(), found);
    }

    #[test]
    fn an_explanation_says_what_else_is_wrong_with_the_robot() {
        let text = format!(
            r#"{{"schema":"mlr.explanation/1","morphology":{MORPHOLOGY},"effects":[
                {{"kind":"payload","parameters":{{"mass_kg":0.4,"x_m":0.02,"y_m":-0.01}}}},
                {{"kind":"weak_leg","parameters":{{"leg":2,"gain":0.4}}}},
                {{"kind":"servo_stiffness","parameters":{{"stiffness":21}}}},
                {{"kind":"gyro_bias","parameters":{{"x_dps":1,"y_dps":0,"z_dps":0}}}}]}}"#
        );
        let found = read(&text).unwrap();
        assert_eq!(found.left_out, ["gyro_bias"]);
        let weak = Fault::WeakLeg { leg: 2, gain: 0.4 };
        assert_eq!(found.settings.faults, [weak]);
        let [x_m, y_m, z_m] = found.settings.payload.unwrap().position_m;
        assert_eq!([x_m, y_m], [0.02, -0.01]);
        assert!(z_m > 0.018);
        assert_eq!(found.robot.servo().stiffness_nm_per_rad, 21.0);
        assert!(!found.doubtful);
    }

    #[test]
    fn what_is_no_answer_is_refused_with_what_was_expected() {
        let other = "[[1,1,1],[1,1,1]]";
        for (text, told) in [
            ("{}".to_string(), "schema: nothing is not valid"),
            ("[1]".to_string(), "schema: nothing is not valid"),
            ("no JSON".to_string(), "mlr-ga identify --json"),
            (
                r#"{"schema":"mlr.detection/1"}"#.to_string(),
                "mlr.detection/1",
            ),
            (
                r#"{"schema":"mlr.explanation/1"}"#.to_string(),
                "morphology",
            ),
            (
                format!(r#"{{"schema":"mlr.identification/1","morphology":{other}}}"#),
                "legs of 3, 3 links",
            ),
            (
                format!(
                    r#"{{"schema":"mlr.explanation/1","morphology":{MORPHOLOGY},"effects":[{{"kind":"weak_leg","parameters":{{"leg":9,"gain":0.4}}}}]}}"#
                ),
                "faults[0].leg: 9",
            ),
            (
                format!(
                    r#"{{"schema":"mlr.explanation/1","morphology":{MORPHOLOGY},"effects":[{{"kind":"payload","parameters":{{"mass_kg":1}}}}]}}"#
                ),
                "effects[0].parameters.x_m",
            ),
        ] {
            let message = read(&text).unwrap_err().to_string();
            assert!(message.contains(told), "{text}: {message}");
        }
    }
}
