//! From a log of a recovery gait to the same gait, steered.

use mlr_filter::{MotionStart, NoTurning, SettingError, SteadyWalk, Turning};
use mlr_imu::{Recording, quality::LogQuality};
use mlr_model::Robot;
use mlr_recover::{RecoverError, RecoverSettings, Steered, WalkedPlan};
use serde::Serialize;
use serde_json::Value;
use thiserror::Error;

use super::{ReportedGait, report};
use crate::{
    AnswerError, AnswerJsonError, DetectionSettings, Model, answer_json::printed_object,
    recording::repair_time_stamps,
};

/// Version of the JSON form.
const SCHEMA: &str = "mlr.steering/1";

/// Why a gait is not steered.
#[derive(Debug, Error)]
pub enum SteerError {
    /// What the robot was recorded doing does not answer.
    #[error(transparent)]
    Recording(#[from] AnswerError),
    /// It does not tell how the robot turns.
    #[error(transparent)]
    Turning(#[from] NoTurning),
    /// No such gait can be made.
    #[error(transparent)]
    Gait(#[from] RecoverError),
}

impl SteerError {
    /// Whether the recording is at fault, rather than what was asked of it.
    pub fn is_recordings_fault(&self) -> bool {
        match self {
            Self::Recording(error) => error.is_recordings_fault(),
            Self::Turning(_) => true,
            Self::Gait(_) => false,
        }
    }
}

/// Why a report tells of no gait.
#[derive(Debug, Error)]
pub enum GaitJsonError {
    /// It is no JSON, or of another form.
    #[error("{0}, expected a report as mlr-ga recover --json or steer --json prints it")]
    Form(#[from] serde_json::Error),
    /// It reports something else.
    #[error(
        "schema: {0} is not valid, expected a report of recover or steer (\"mlr.recovery/1\" or \
         \"mlr.steering/1\"), as mlr-ga prints it with --json"
    )]
    Schema(String),
    /// It is of another robot.
    #[error(transparent)]
    Robot(#[from] AnswerJsonError),
    /// A number makes no sense.
    #[error(transparent)]
    Number(#[from] SettingError),
}

/// Reads the gait of a report of `recover` or `steer`, or of an event of the daemon with one.
///
/// # Errors
/// [`GaitJsonError`] when the text is no such report, or of another robot.
pub fn gait_of_json(text: &str, robot: &Robot) -> Result<ReportedGait, GaitJsonError> {
    let value = printed_object(text)?;
    match &value["schema"] {
        Value::String(schema) if [report::SCHEMA, SCHEMA].contains(&schema.as_str()) => {}
        Value::Null => return Err(GaitJsonError::Schema("nothing".into())),
        found => return Err(GaitJsonError::Schema(found.to_string())),
    }
    let gait: ReportedGait = serde_json::from_value(value)?;
    AnswerJsonError::check_robot(&gait.morphology, robot)?;
    gait.check_on(robot)?;
    Ok(gait)
}

/// How a robot turned, and the gait that makes up for it.
#[derive(Debug, Clone)]
pub struct Steering {
    /// How it turned in each cycle.
    pub turning: Turning,
    /// The gait.
    pub steered: Steered,
    /// What a person should know about the recording.
    pub warnings: Vec<String>,
}

/// Steers a recovery gait by a recording of the robot that walked with it. The model is that of the robot
/// in full health with its nominal gait.
///
/// # Errors
/// [`SteerError`].
pub fn steer(
    recording: &Recording,
    gait: &ReportedGait,
    model: Model<'_>,
    detection: &DetectionSettings,
    settings: &RecoverSettings,
) -> Result<Steering, SteerError> {
    detection.check().map_err(AnswerError::from)?;
    let mut warnings = recording.notes.clone();
    let recording = repair_time_stamps(recording, detection.max_dropped_share, &mut warnings)?;
    let quality = LogQuality::of(&recording, &detection.motion);
    let start = MotionStart::find(&recording.orientation, &detection.motion);
    let start = start.map_err(AnswerError::from)?;
    if let Some(finding) = quality.spoilt_within(start.start_s..f64::INFINITY) {
        return Err(AnswerError::from(finding.clone()).into());
    }
    warnings.extend(quality.warnings());
    let steady = SteadyWalk {
        start,
        steady_from_s: gait.steady_from_s,
        cycle_s: gait.period_s,
    };
    let turning = Turning::of(&recording.orientation, steady, &detection.motion)?;
    let (left, plan) = (gait.left(), gait.plan());
    let of = WalkedPlan {
        robot: model.robot,
        nominal: model.gait,
        left: &left,
        plan: &plan,
    };
    Ok(Steering {
        steered: of.steered(turning.mean_rad(), settings)?,
        turning,
        warnings,
    })
}

/// How a gait was steered, as other programs read it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SteeringReport {
    /// Name and version of the form.
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA)))]
    schema: &'static str,
    /// The recording.
    pub log: String,
    /// The steered gait, and what it is for.
    #[serde(flatten)]
    pub gait: ReportedGait,
    /// Cycles of the gait before that were recorded.
    pub cycles: usize,
    /// How far the robot turned in a cycle, to the left.
    pub turned_deg: f64,
    /// Standard deviation of that, by how much cycles differ; null of a single one.
    pub turned_deviation_deg: Option<f64>,
    /// The same over how far the gait moves the body forward.
    pub drift_deg_per_m: f64,
    /// By how much the gait before was steered.
    pub steering_before_deg: f64,
    /// Rate of yaw while the robot stood, which is taken for the gyroscope's bias.
    pub standing_dps: f64,
    /// Whether the centre of mass stays over the feet that stand.
    pub statically_stable: bool,
    /// Least distance of the centre of mass from the edge of the feet that stand.
    pub margin_m: f64,
    /// The same on the way into the gait.
    pub first_steps_margin_m: f64,
    /// Warnings for people.
    pub warnings: Vec<String>,
}

impl SteeringReport {
    /// The report of a gait that was steered by the recording of this name.
    pub fn new(log: String, before: &ReportedGait, found: &Steering) -> Self {
        let (turning, steered) = (&found.turning, &found.steered);
        let turned_deg = turning.mean_rad().to_degrees();
        Self {
            schema: SCHEMA,
            log,
            gait: ReportedGait::new(&before.left(), &steered.plan, &steered.gait),
            cycles: turning.cycles(),
            turned_deg,
            turned_deviation_deg: turning.deviation_rad().map(f64::to_degrees),
            drift_deg_per_m: turned_deg / before.stride_m.abs().max(LEAST_STRIDE_M),
            steering_before_deg: before.steering_deg,
            standing_dps: turning.standing_rad_per_s().to_degrees(),
            statically_stable: steered.margin_m > 0.0,
            margin_m: steered.margin_m,
            first_steps_margin_m: steered.first_steps_margin_m,
            warnings: found.warnings.clone(),
        }
    }
}

/// Of a gait that moves the body less than this, a drift per metre means nothing.
const LEAST_STRIDE_M: f64 = 0.002;
