//! What an explanation of a walk says.

use std::collections::BTreeMap;

use mlr_filter::{Axes, Axis};
use mlr_model::Morphology;
use serde::{Deserialize, Serialize};

use super::{AxisResidual, Sensing};

/// Why the walk of a robot differs from that of its model.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WalkExplanation {
    /// The morphology as identified at first.
    pub morphology_before: Morphology,
    /// The same with all effects in place.
    pub morphology: Morphology,
    /// Numbers (from 1) of the legs that miss a link.
    pub damaged_legs: Vec<usize>,
    /// Probability of each kind of effect to be in the robot; `none`: that nothing is wrong with it
    /// but that links are gone; `unknown`: that something is that no effect of the library makes.
    /// Of two effects at once both count, so that the sum may exceed 1.
    pub effect_probability: BTreeMap<String, f64>,
    /// The most probable set of effects; empty where the model lacks nothing.
    pub effects: Vec<TracedEffect>,
    /// The most probable hypotheses.
    pub alternatives: Vec<WalkAlternative>,
    /// Whether something that no effect of the library makes is more probable than not.
    pub unexplained: bool,
    /// Error of the robot as described: only the zeros of time and heading are fitted.
    pub error_before: StretchErrors,
    /// Error with the nuisance parameters fitted, without effects.
    pub error_calibrated: StretchErrors,
    /// Error with all effects.
    pub error_after: StretchErrors,
    /// Error that sensor noise and the model's own shortcomings leave.
    pub noise_floor_deg: f64,
    /// Nuisance parameters as fitted, in standard deviations of their priors.
    pub nuisance: BTreeMap<String, f64>,
    /// Kinds that are not among the effects, the most probable first.
    pub candidates: Vec<WalkCandidate>,
    /// What remains.
    pub residual: RemainingResidual,
    /// The residual of the most probable robot without effects, its nuisance parameters fitted,
    /// split into what physics tells apart.
    pub residual_before: ByAxis,
    /// The same with all effects.
    pub residual_after: ByAxis,
    /// Log times of the stretches that errors are measured on.
    pub stretches_s: StretchesS,
    /// What else to know.
    pub warnings: Vec<String>,
}

impl WalkExplanation {
    /// What was found of the sensor: its faults beyond the usual, for correcting what it
    /// says from now on. A bias that drifts is not among them, because it belongs to the
    /// time of the log; nor is what could be something else as well.
    pub fn sensing(&self) -> Sensing {
        let mut sensing = Sensing::default();
        let sure = |effect: &&TracedEffect| effect.rivals.is_empty() && effect.at_bound.is_empty();
        for effect in self.effects.iter().filter(sure) {
            let value = |name: &str, absent: f64| match effect.parameters.get(name) {
                Some(Reported::Quantity(value)) => *value,
                _ => absent,
            };
            match effect.kind.as_str() {
                "imu_misalignment" => {
                    let tilt_deg = ["roll_deg", "pitch_deg"].map(|name| value(name, 0.0));
                    sensing.misalignment_deg[..2].copy_from_slice(&tilt_deg);
                }
                "gyro_bias" => {
                    sensing.bias_dps = ["x_dps", "y_dps", "z_dps"].map(|name| value(name, 0.0));
                }
                "gyro_scale" => sensing.scale = value("scale", 1.0),
                "sensor_delay" => sensing.delay_s = value("delay_s", 0.0),
                _ => {}
            }
        }
        sensing
    }
}

/// Root mean square errors, degrees.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct StretchErrors {
    /// Over all axes, on the stretch that parameters were fitted on.
    pub fit_deg: f64,
    /// Over all axes, on the stretch that they never saw.
    pub validation_deg: f64,
    /// Roll, pitch, yaw on the fitted stretch.
    pub fit_axes_deg: [f64; 3],
    /// Roll, pitch, yaw on the unseen stretch.
    pub validation_axes_deg: [f64; 3],
}

impl StretchErrors {
    pub(crate) fn new(fit_deg2: [f64; 3], unseen_deg2: [f64; 3]) -> Self {
        let over_all = |squares: [f64; 3]| (squares.iter().sum::<f64>() / 3.0).sqrt();
        Self {
            fit_deg: over_all(fit_deg2),
            validation_deg: over_all(unseen_deg2),
            fit_axes_deg: fit_deg2.map(f64::sqrt),
            validation_axes_deg: unseen_deg2.map(f64::sqrt),
        }
    }
}

/// The value of a parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum Reported {
    /// The number of a leg, link or joint, from 1.
    Number(usize),
    /// Several such numbers.
    Numbers(Vec<usize>),
    /// A quantity in the unit of its name.
    Quantity(f64),
}

impl Reported {
    pub(crate) fn new(name: &str, value: f64) -> Self {
        match name {
            "leg" | "link" | "joint" => Self::Number(value as usize),
            _ => Self::Quantity(value),
        }
    }
}

impl std::fmt::Display for Reported {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Numbers(numbers) => {
                let numbers: Vec<String> = numbers.iter().map(usize::to_string).collect();
                write!(f, "{}", numbers.join("+"))
            }
            Self::Quantity(value) => write!(f, "{value:.3}"),
        }
    }
}

/// An effect that was added to the model.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TracedEffect {
    /// Name of the effect.
    pub kind: String,
    /// Value of each parameter; the name ends in the unit.
    pub parameters: BTreeMap<String, Reported>,
    /// 95 % interval of each parameter that the log determines.
    pub interval_95: BTreeMap<String, [f64; 2]>,
    /// Parameters that lie at the bound of what is tried.
    pub at_bound: Vec<String>,
    /// Parameters that the log does not determine.
    pub undetermined: Vec<String>,
    /// What it changes, in words.
    pub explains: String,
    /// Probability of its kind to be in the robot.
    pub probability: f64,
    /// Effects of other sets that together with this one hold 90 % of the probability.
    pub rivals: Vec<Rival>,
}

/// A hypothesis with its probability.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WalkAlternative {
    /// Which links are left.
    pub morphology: Morphology,
    /// Whether the lost ones hang on.
    pub locked_links: bool,
    /// The effects.
    pub effects: Vec<Rival>,
    /// Whether something that no effect of the library makes is there as well.
    pub unknown: bool,
    /// How probable all of this is.
    pub probability: f64,
}

/// Log times of stretches, from and to.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct StretchesS {
    /// What hypotheses are judged and parameters fitted by.
    pub fit: [f64; 2],
    /// What nothing has seen.
    pub validation: [f64; 2],
}

/// An effect with its parameters.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Rival {
    /// Name of the effect.
    pub kind: String,
    /// Its parameters as fitted.
    pub parameters: BTreeMap<String, Reported>,
}

/// An effect that was not added, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WalkCandidate {
    /// Name of the effect.
    pub kind: String,
    /// Its parameters as fitted; empty where the record does not show it.
    pub parameters: BTreeMap<String, Reported>,
    /// Error on the unseen stretch with it.
    pub validation_deg: Option<f64>,
    /// Probability of its kind to be in the robot.
    pub probability: f64,
    /// What was decided.
    pub verdict: String,
}

/// The most striking thing about what remains.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RemainingResidual {
    /// Axis on which most remains, compared with what usually does.
    pub axis: &'static str,
    /// Frequency of the strongest oscillation there.
    pub frequency_hz: Option<f64>,
    /// Its amplitude.
    pub amplitude_deg: Option<f64>,
    /// Whether it repeats with the gait.
    pub locked_to_gait: bool,
    /// Torque about that axis which would swing the free body so.
    pub body_torque_nm: Option<f64>,
    /// Root mean square of what remains there without offset and trend.
    pub remaining_deg: f64,
    /// What is usual there.
    pub usual_deg: f64,
    /// What it looks like.
    pub explains: String,
}

/// Something for each axis, by its name.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ByAxis {
    /// About x.
    pub roll: AxisResidual,
    /// About y.
    pub pitch: AxisResidual,
    /// About z.
    pub yaw: AxisResidual,
}

impl From<Axes<AxisResidual>> for ByAxis {
    fn from(axes: Axes<AxisResidual>) -> Self {
        let Axes { roll, pitch, yaw } = axes;
        Self { roll, pitch, yaw }
    }
}

impl ByAxis {
    /// The axes with their names.
    pub fn each(&self) -> [(Axis, &AxisResidual); 3] {
        [
            (Axis::Roll, &self.roll),
            (Axis::Pitch, &self.pitch),
            (Axis::Yaw, &self.yaw),
        ]
    }
}
