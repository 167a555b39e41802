use mlr_filter::SettingError;
use thiserror::Error;

/// Everything that can be wrong with a robot, a gait, a morphology or the
/// settings of a simulation.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A robot or gait file is not valid TOML of the expected form.
    #[error("{what}: {source}")]
    Syntax {
        /// "robot" or "gait".
        what: &'static str,
        /// Names line, column and the expected form.
        source: Box<toml::de::Error>,
    },
    /// A value is well-formed but makes no sense. Its name is a path, as in `legs[2].hip_m`.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The gait asks a foot to be where the leg cannot bring it.
    #[error(
        "leg {leg} cannot reach the gait's foot target ({x_m:.4}, {y_m:.4}, {z_m:.4}) m at gait time {time_s:.3} s: \
         it stops {miss_m:.4} m short"
    )]
    Unreachable {
        /// Leg number, from 1.
        leg: usize,
        /// Gait time of the target.
        time_s: f64,
        /// Target, body frame.
        x_m: f64,
        /// Target, body frame.
        y_m: f64,
        /// Target, body frame.
        z_m: f64,
        /// Distance between the target and the nearest point found.
        miss_m: f64,
    },
    /// The gait was made for a robot with another number of legs.
    #[error("the gait has {gait} phase offsets, the robot has {robot} legs")]
    LegCount {
        /// Phase offsets of the gait.
        gait: usize,
        /// Legs of the robot.
        robot: usize,
    },
    /// The text that a robot is to be written into describes one with other legs.
    #[error("the text describes a robot with other legs or links, expected the description of {0}")]
    OtherRobot(String),
    /// The gait was made for a robot with another number of joints.
    #[error("the gait has {gait} joint angles in a row, the robot has {robot} joints")]
    JointCount {
        /// Angles in a row of the gait.
        gait: usize,
        /// Joints of the robot.
        robot: usize,
    },
    /// A joint trajectory is not CSV of the expected form.
    #[error("line {line}: {reason}")]
    JointsCsv {
        /// Line of the text, from 1.
        line: usize,
        /// What was found and what was expected.
        reason: String,
    },
    /// The robot would lie on its belly.
    #[error(
        "in the gait's stance no leg reaches the ground: the body's underside is at \
         {underside_m:.4} m, the lowest point with which a leg can touch the ground at \
         {lowest_m:.4} m; expected a larger body_height_m of the gait, legs that reach further \
         down in the first row of its joints_rad, or a robot whose links with a contact do"
    )]
    NoFooting {
        /// Height of the body's underside over its origin.
        underside_m: f64,
        /// Height of the lowest point of any leg that can touch the ground.
        lowest_m: f64,
    },
    /// A morphology's text or numbers do not fit the robot.
    #[error("morphology {text:?}: {reason}")]
    Morphology {
        /// What was given.
        text: String,
        /// Why it does not fit.
        reason: String,
    },
}
