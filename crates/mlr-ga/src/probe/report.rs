//! What a calibration motion says of itself, as JSON.

use std::{collections::BTreeMap, fmt};

use mlr_model::{MotionSegment, RobotParameter};
use mlr_residual::walk::{Information, NuisanceSettings};
use serde::Serialize;

use super::{CalibrationMotion, mean_gain_nats};

/// Version of the JSON form.
const SCHEMA: &str = "mlr.probe/1";

/// A calibration motion with what is to be expected of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ProbeReport {
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA)))]
    schema: &'static str,
    /// How long it lasts.
    pub duration_s: f64,
    /// What it is made of, in order.
    pub segments: Vec<ReportedSegment>,
    /// How many candidate segments were looked at.
    pub candidates: usize,
    /// How many of them were left out, by what some robots of the make would do.
    pub left_out: BTreeMap<String, usize>,
    /// Of how many robots of the make the expectations are means.
    pub robots: usize,
    /// Reduction of the entropy of the robot's parameters by a plain walk, nats.
    pub walk_gain_nats: f64,
    /// The same by the motion.
    pub motion_gain_nats: f64,
    /// The robot's own parameters.
    pub parameters: Vec<ReportedParameter>,
}

/// One segment.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ReportedSegment {
    /// What the robot does.
    #[serde(flatten)]
    pub motion: ReportedMotion,
    /// From stance to stance.
    pub duration_s: f64,
    /// Reduction of entropy that it makes alone, nats.
    pub gain_nats: f64,
}

/// What a robot does in a segment.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum ReportedMotion {
    /// It walks while legs are folded.
    Walk {
        /// Their numbers.
        folded_legs: Vec<usize>,
        /// Length of the stride.
        stride_m: f64,
        /// Height of a swinging foot.
        lift_m: f64,
        /// Of a step cycle.
        period_s: f64,
    },
    /// A leg presses on the ground.
    Press {
        /// Its number.
        leg: usize,
        /// Number of the joint that presses.
        joint: usize,
        /// To which angle.
        angle_rad: f64,
        /// How far the body is lowered.
        lowered_m: f64,
        /// How often.
        times: usize,
    },
    /// The robot turns on the spot.
    Turn {
        /// By how much in each step; positive to the left.
        step_rad: f64,
        /// Step cycles until the steps begin to shrink.
        cycles: usize,
    },
    /// The body rolls to one side and back.
    Nod {
        /// How far.
        roll_rad: f64,
    },
}

/// Standard deviations of a parameter in its coordinate: root mean squares over robots of the make.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ReportedParameter {
    /// Its name.
    pub name: String,
    /// What the numbers are in: `ln` for the logarithm of a positive number.
    pub unit: &'static str,
    /// As known before.
    pub before: f64,
    /// After a plain walk.
    pub after_walk: f64,
    /// After the motion.
    pub after_motion: f64,
}

impl ProbeReport {
    /// The report of a motion.
    pub fn new(motion: &CalibrationMotion, make: &NuisanceSettings) -> Self {
        let before: Vec<_> = motion
            .of_motion
            .iter()
            .map(Information::deviations_before)
            .collect();
        let walk: Vec<_> = motion.of_walk.iter().map(Information::deviations).collect();
        let moved: Vec<_> = motion
            .of_motion
            .iter()
            .map(Information::deviations)
            .collect();
        let parameters = before
            .first()
            .map_or(&[][..], Vec::as_slice)
            .iter()
            .enumerate();
        let segments = motion.segments.iter().map(|segment| {
            let walk = MotionSegment::Walk(segment.walk.clone());
            ReportedSegment::new(&walk, segment.duration_s, segment.gain_nats)
        });
        Self {
            schema: SCHEMA,
            duration_s: motion.gait.duration_s().unwrap_or_default(),
            segments: segments.collect(),
            candidates: motion.candidates,
            left_out: motion.left_out.clone(),
            robots: motion.of_motion.len(),
            walk_gain_nats: mean_gain_nats(&motion.of_walk),
            motion_gain_nats: mean_gain_nats(&motion.of_motion),
            parameters: parameters
                .map(|(row, (parameter, _))| {
                    let of_make = make.of_make(*parameter);
                    let mean = |each: &[Vec<(RobotParameter, f64)>]| {
                        let squares = each.iter().filter_map(|one| one.get(row));
                        let sum: f64 = squares.map(|(_, deviation)| deviation * deviation).sum();
                        of_make * (sum / each.len().max(1) as f64).sqrt()
                    };
                    ReportedParameter {
                        name: parameter.to_string(),
                        unit: parameter.unit(),
                        before: mean(&before),
                        after_walk: mean(&walk),
                        after_motion: mean(&moved),
                    }
                })
                .collect(),
        }
    }
}

impl ReportedSegment {
    pub(crate) fn new(motion: &MotionSegment, duration_s: f64, gain_nats: f64) -> Self {
        Self {
            motion: ReportedMotion::new(motion),
            duration_s,
            gain_nats,
        }
    }
}

impl ReportedMotion {
    fn new(motion: &MotionSegment) -> Self {
        match motion {
            MotionSegment::Walk(walk) => {
                let feet = walk.gait.feet();
                Self::Walk {
                    folded_legs: walk.folded_legs.iter().map(|leg| leg + 1).collect(),
                    stride_m: feet.map_or(0.0, |feet| feet.stride_m),
                    lift_m: feet.map_or(0.0, |feet| feet.lift_m),
                    period_s: walk.gait.period_s,
                }
            }
            MotionSegment::Turn(turn) => Self::Turn {
                step_rad: turn.step_rad,
                cycles: turn.cycles,
            },
            MotionSegment::Press(press) => Self::Press {
                leg: press.leg + 1,
                joint: press.joint + 1,
                angle_rad: press.pose_rad.get(press.joint).copied().unwrap_or(0.0),
                lowered_m: press.lowered_m,
                times: press.times,
            },
            MotionSegment::Nod(nod) => Self::Nod {
                roll_rad: nod.roll_rad,
            },
        }
    }
}

/// For people, in one line.
impl fmt::Display for ReportedMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Walk {
                folded_legs,
                stride_m,
                lift_m,
                period_s,
            } => {
                let legs: Vec<String> = folded_legs.iter().map(usize::to_string).collect();
                match legs.len() {
                    0 => write!(f, "walk")?,
                    1 => write!(f, "walk, leg {} folded", legs[0])?,
                    _ => write!(f, "walk, legs {} folded", legs.join(", "))?,
                }
                let (stride_mm, lift_mm) = (1e3 * stride_m, 1e3 * lift_m);
                write!(
                    f,
                    ", stride {stride_mm:.0} mm, lift {lift_mm:.0} mm, period {period_s:.1} s"
                )
            }
            Self::Press {
                leg,
                joint,
                angle_rad,
                lowered_m,
                times,
            } => {
                let (angle_deg, lowered_mm) = (angle_rad.to_degrees(), 1e3 * lowered_m);
                write!(
                    f,
                    "leg {leg} presses with joint {joint} at {angle_deg:.0}°, "
                )?;
                write!(f, "{times} times, body {lowered_mm:.0} mm lower")
            }
            Self::Turn { step_rad, cycles } => {
                let (side, step_deg) = match *step_rad >= 0.0 {
                    true => ("left", step_rad.to_degrees()),
                    false => ("right", -step_rad.to_degrees()),
                };
                write!(
                    f,
                    "turn on the spot to the {side}, {cycles} cycles of steps of {step_deg:.0}°"
                )
            }
            Self::Nod { roll_rad } => write!(f, "nod, roll {:.0}°", roll_rad.to_degrees()),
        }
    }
}
