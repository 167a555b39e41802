//! What a calibration motion says of itself, as JSON.

use std::collections::BTreeMap;

use mlr_model::{FoldedWalk, RobotParameter};
use mlr_residual::walk::{Information, NuisanceSettings};
use serde::Serialize;

use super::{CalibrationMotion, mean_gain_nats};

/// Version of the JSON form.
const SCHEMA: &str = "mlr.probe/1";

/// A calibration motion with what is to be expected of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ProbeReport {
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
pub struct ReportedSegment {
    /// Numbers of the folded legs.
    pub folded_legs: Vec<usize>,
    /// Length of the stride.
    pub stride_m: f64,
    /// Height of a swinging foot.
    pub lift_m: f64,
    /// Of a step cycle.
    pub period_s: f64,
    /// From stance to stance.
    pub duration_s: f64,
    /// Reduction of entropy that it makes alone, nats.
    pub gain_nats: f64,
}

/// Standard deviations of a parameter in its coordinate: root mean squares over robots of the make.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
        Self {
            schema: SCHEMA,
            duration_s: motion.gait.duration_s().unwrap_or_default(),
            segments: motion.segments.iter().map(ReportedSegment::new).collect(),
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
    fn new(segment: &super::Segment) -> Self {
        Self::of_walk(&segment.walk, segment.duration_s, segment.gain_nats)
    }

    pub(crate) fn of_walk(walk: &FoldedWalk, duration_s: f64, gain_nats: f64) -> Self {
        let feet = walk.gait.feet();
        Self {
            folded_legs: walk.folded_legs.iter().map(|leg| leg + 1).collect(),
            stride_m: feet.map_or(0.0, |feet| feet.stride_m),
            lift_m: feet.map_or(0.0, |feet| feet.lift_m),
            period_s: walk.gait.period_s,
            duration_s,
            gain_nats,
        }
    }
}
