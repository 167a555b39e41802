//! Motions that are made of parts, each from the stance to the stance.

use mlr_filter::SettingError;

use super::{
    BodyNod, FoldedWalk, FootMotion, Gait, JointTrajectory, LegPress, Motion, TurnInPlace,
};
use crate::{ModelError, Robot};

/// A part of a motion that asks a robot something.
#[derive(Debug, Clone, PartialEq)]
pub enum MotionSegment {
    /// Some steps while legs are folded.
    Walk(FoldedWalk),
    /// Some steps in which the robot turns on the spot.
    Turn(TurnInPlace),
    /// One leg presses on the ground.
    Press(LegPress),
    /// The body rolls to one side and back.
    Nod(BodyNod),
}

/// How fast the posture changes between the parts of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SegmentTiming {
    /// How long legs take to fold and the body to be lowered; longer where the servos are too slow for
    /// that.
    pub fold_s: f64,
    /// How long the robot stands after each segment.
    pub stand_s: f64,
}

impl Default for SegmentTiming {
    fn default() -> Self {
        Self {
            fold_s: 0.8,
            stand_s: 0.2,
        }
    }
}

/// How much of its way a motion of least jerk has done after this share of its time (Flash and Hogan
/// 1985).
pub fn least_jerk_share(t: f64) -> f64 {
    t * t * t * (10.0 + t * (6.0 * t - 15.0))
}

/// Greatest speed of a motion of least jerk, over its mean speed.
pub const LEAST_JERK_PEAK: f64 = 1.875;
/// Within this share of a row a time counts as that row's.
const TOLERANCE: f64 = 1e-6;

impl MotionSegment {
    /// One row for each command of the servos; the first and the last are the stance.
    fn rows_rad(&self, robot: &Robot, timing: SegmentTiming) -> Result<Vec<Vec<f64>>, ModelError> {
        match self {
            Self::Walk(walk) => walk.rows_rad(robot, timing),
            Self::Turn(turn) => turn.rows_rad(robot),
            Self::Press(press) => press.rows_rad(robot, timing),
            Self::Nod(nod) => nod.rows_rad(robot),
        }
    }
}

impl JointTrajectory {
    /// The robot does one segment after the other, and stands for a moment after each. One row for
    /// each command of the servos.
    ///
    /// # Errors
    /// [`ModelError::Setting`] where a number makes no sense, a gait is no motion of feet, segments
    /// begin in different stances, a leg is not the robot's, or a joint would have to turn faster than
    /// its servo can; [`ModelError::LegCount`] and [`ModelError::Unreachable`] where gait and robot do
    /// not fit.
    pub fn of_segments(
        robot: &Robot,
        segments: &[MotionSegment],
        timing: SegmentTiming,
    ) -> Result<Self, ModelError> {
        SettingError::check("fold_s", timing.fold_s, 0.0..=60.0, "s")?;
        SettingError::check("stand_s", timing.stand_s, 0.0..=60.0, "s")?;
        let hold_s = robot.servo().command_hold_s;
        let mut rows_rad: Vec<Vec<f64>> = Vec::new();
        for (index, segment) in segments.iter().enumerate() {
            let of_segment_rad = segment.rows_rad(robot, timing)?;
            let [stance_rad, moved_rad @ ..] = of_segment_rad.as_slice() else {
                continue;
            };
            match rows_rad.first() {
                None => rows_rad.push(stance_rad.clone()),
                Some(first) if furthest_rad(first, stance_rad) > 1e-9 => {
                    let (name, expected) = (format!("segments[{index}]"), "that of the first one");
                    return Err(SettingError::new(name, "another stance", expected).into());
                }
                Some(_) => {}
            }
            rows_rad.extend_from_slice(moved_rad);
            let standing = rows(timing.stand_s, hold_s);
            rows_rad.extend(std::iter::repeat_n(stance_rad.clone(), standing));
        }
        check_speed(robot, &rows_rad)?;
        Ok(Self::new(hold_s, rows_rad, None)?)
    }
}

impl Gait {
    /// The same as a gait that ends.
    ///
    /// # Errors
    /// Those of [`JointTrajectory::of_segments`].
    pub fn of_segments(
        name: &str,
        period_s: f64,
        robot: &Robot,
        segments: &[MotionSegment],
    ) -> Result<Self, ModelError> {
        let joints = JointTrajectory::of_segments(robot, segments, SegmentTiming::default())?;
        Ok(Self {
            name: name.into(),
            period_s,
            motion: Motion::Joints(joints),
        })
    }
}

/// The motion of feet of a gait that the robot can walk as far as its legs go.
pub(super) fn feet_of<'g>(gait: &'g Gait, robot: &Robot) -> Result<&'g FootMotion, ModelError> {
    let feet = gait.feet();
    let feet = feet.ok_or_else(|| SettingError::new("gait", &gait.name, "the motion of feet"))?;
    if feet.phase_offsets.len() != robot.legs().len() {
        return Err(ModelError::LegCount {
            gait: feet.phase_offsets.len(),
            robot: robot.legs().len(),
        });
    }
    gait.check()?;
    Ok(feet)
}

/// From the first of so many step cycles to the last step.
pub(super) fn walked_s(gait: &Gait, feet: &FootMotion, cycles: usize) -> f64 {
    cycles as f64 * gait.period_s + feet.ramp_s
}

/// The motion of feet so long before its last step: over the ramp at the end strides shrink.
pub(super) fn ending(feet: &FootMotion, left_s: f64) -> FootMotion {
    let share = match left_s {
        left_s if left_s >= feet.ramp_s => 1.0,
        left_s => (left_s / feet.ramp_s).max(0.0),
    };
    FootMotion {
        stride_m: share * feet.stride_m,
        lift_m: share * feet.lift_m,
        ..feet.clone()
    }
}

pub(super) fn check_leg(name: &str, leg: usize, robot: &Robot) -> Result<(), SettingError> {
    if leg < robot.legs().len() {
        return Ok(());
    }
    let expected = format!("legs of {}, from 0", robot.name());
    Err(SettingError::new(name, leg, expected))
}

/// How many rows last so long at least.
pub(super) fn rows(duration_s: f64, hold_s: f64) -> usize {
    (duration_s / hold_s - TOLERANCE).ceil().max(0.0) as usize
}

pub(super) fn furthest_rad(from_rad: &[f64], to_rad: &[f64]) -> f64 {
    let each = from_rad
        .iter()
        .zip(to_rad)
        .map(|(from, to)| (to - from).abs());
    each.fold(0.0, f64::max)
}

/// How long a motion of least jerk between two poses takes: so long, or as long as servos need.
pub(super) fn least_s(robot: &Robot, from_rad: &[f64], to_rad: &[f64], wanted_s: f64) -> f64 {
    let furthest_rad = furthest_rad(from_rad, to_rad);
    wanted_s.max(LEAST_JERK_PEAK * furthest_rad / robot.servo().speed_limit_rad_per_s)
}

/// Rows from one pose to another with the least jerk, without the first.
pub(super) fn least_jerk(
    from_rad: &[f64],
    to_rad: &[f64],
    duration_s: f64,
    hold_s: f64,
) -> impl Iterator<Item = Vec<f64>> {
    let count = rows(duration_s, hold_s);
    (1..=count).map(move |row| {
        if row == count {
            return to_rad.to_vec();
        }
        let share = least_jerk_share(row as f64 / count as f64);
        let each = from_rad.iter().zip(to_rad);
        each.map(|(from, to)| from + share * (to - from)).collect()
    })
}

/// Whether servos can follow from row to row.
fn check_speed(robot: &Robot, rows_rad: &[Vec<f64>]) -> Result<(), SettingError> {
    let servo = robot.servo();
    let limit_rad_per_s = servo.speed_limit_rad_per_s;
    for (row, pair) in rows_rad.windows(2).enumerate() {
        let [from_rad, to_rad] = pair else { continue };
        let speed_rad_per_s = furthest_rad(from_rad, to_rad) / servo.command_hold_s;
        if speed_rad_per_s > limit_rad_per_s * (1.0 + TOLERANCE) {
            let found = format!("{speed_rad_per_s:.2} rad/s");
            let expected = format!("at most {limit_rad_per_s} rad/s, which the servos reach");
            return Err(SettingError::new(
                format!("row {}", row + 1),
                found,
                expected,
            ));
        }
    }
    Ok(())
}
