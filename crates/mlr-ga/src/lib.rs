//! Finds the damaged legs of a legged robot in a recording of its body IMU.
//!
//! [`identify()`] finds the start of the walk, searches the feasible morphologies ([`genetic`],
//! [`exact`]), and decides by one of two methods ([`Method`]):
//!
//! - **mlr**, the default: measured and simulated walk are compared by their spectra below the
//!   filter's cutoff ([`comparison`]); likelihood times prior probability, over variations of
//!   the model, gives a probability to every morphology ([`belief`]), and the most probable is
//!   the answer. The search only proposes candidates. The paper's cost F is reported and decides
//!   nothing.
//! - **paper**, the method as published: F ([`PaperCost`]) on signals conditioned by Algorithm 2
//!   of the paper, least over what the genetic algorithm meets; the most frequent result of ten
//!   runs is the answer.
//!
//! [`detect()`] finds out when the damage happened, [`explain()`] what else the model lacks.
//!
//! ```
//! use mlr_ga::{IdentifySettings, Model, identify};
//! use mlr_model::{Gait, Morphology, Outcome, Robot, SimulationSettings, Simulator};
//!
//! // A recording of a robot that stands for a second and then walks without leg 2.
//! let robot = Robot::jethexa();
//! let truth = Morphology::parse_legs_lost("2", &robot.layout())?;
//! let settings = SimulationSettings { stand_s: 1.0, duration_s: 4.0, ..Default::default() };
//! let Outcome::Walked(walk) =
//!     Simulator::new(robot, &Gait::tripod(), settings)?.simulate(&truth)
//! else {
//!     panic!("the simulation diverged");
//! };
//!
//! let mut settings = IdentifySettings { window_s: 2.0, ..Default::default() };
//! settings.genetic.generations = 5;
//! let answer = identify(&walk.orientation.into(), Model::jethexa(), &settings, &())?;
//! assert!(answer.damaged_legs.contains(&2));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod answer_error;
mod answer_json;
mod answered_robot;
pub mod atlas;
pub mod belief;
mod calibrate;
mod compare;
pub mod comparison;
mod configuration;
mod cost;
mod detect;
mod diagnose;
mod documented_settings;
mod evaluation;
pub mod exact;
mod explain;
pub mod genetic;
mod identify;
mod model;
mod model_files;
mod objective;
mod paper_cost;
mod probe;
mod recording;
mod recover;
mod robot_check;
pub mod scoring;
mod shard;
mod simulate;
pub mod walks;

pub use answer_error::{AnswerError, says_log_cannot_answer};
pub use answer_json::{AnswerJsonError, Question, answer_of_json};
pub use answered_robot::{AnsweredRobot, AnsweredRobotError};
pub use calibrate::{
    CalibrateError, Calibrated, CalibrationReport, HealthyWalk, MeasuredReport, ParameterReport,
    WalkOrigin, WalkReport, calibrate,
};
pub use compare::{Comparison, compare, compare_fit};
pub use configuration::{
    Configuration, ConfigurationError, LARGEST_SEED, checked_toml, most_threads,
};
pub use cost::{mean_error_deg, orientation_error_rad};
pub use detect::{Detection, DetectionReport, DetectionSettings, detect};
pub use diagnose::{
    DiagnosisMotion, DiagnosisReport, DiagnosisSegment, OpenEffect, OpenQuestion, OpenRobot,
    diagnosis_motion,
};
pub use documented_settings::documented_toml;
pub use evaluation::{CaseFit, Evaluation, Evaluations, Objective, Progress};
pub use explain::{
    ExplainError, ExplainSettings, Explained, ExplanationReport, earlier_effects_of_json, explain,
    explain_after, walk_record,
};
pub use identify::{
    Alternative, BestFit, ComparedSignals, Course, Frequency, GaitPhase, Identification,
    IdentificationReport, IdentifiedLog, IdentifyOverrides, IdentifySettings, LogReport,
    MeasuredWalk, Method, RecordedWalk, Search, Stretch, WalkOffsets, WalkStart, identify,
    identify_together,
};
pub use model::Model;
pub use model_files::{
    DescribedRobot, ModelFileError, explanation_settings, gait_of_file, robot_of_file,
};
pub use objective::{Fit, LossHypothesis, Tried, WalkObjective};
pub use paper_cost::{PaperCost, PaperFit};
pub use probe::{
    CalibrationMotion, ProbeError, ProbeReport, ProbeSettings, ReportedParameter, ReportedSegment,
    Segment, calibration_motion,
};
pub use recover::{
    GaitJsonError, NoRecovery, RecoveryOf, RecoveryReport, ReportedGait, ReportedOutlook,
    SteerError, Steering, SteeringReport, diagnosis_of_explanation, diagnosis_of_identification,
    diagnosis_of_json, gait_of_json, recovery_gait, steer,
};
pub use robot_check::{RobotCheck, UnfitRobot, check_robot, stance_center_m, stance_joints_m};
pub use shard::{Shard, ShardError};
pub use simulate::{LogSimulation, SimulateError, SimulationReport};

// What every use of this crate needs of the others.
pub use mlr_imu::{Columns, Recording, read_log};
pub use mlr_model::{Gait, Morphology, Robot};
pub use mlr_residual::walk::EvidenceSettings;
