//! Walks with legs folded on command, one after the other.

use mlr_filter::SettingError;

use super::{FootMotion, Gait, JointTrajectory};
use crate::{ModelError, Robot, joint_commands::reaching};

/// Some steps of a gait while legs are folded: clear of the ground, in the pose in which the robot's
/// description has locked links.
///
/// The stride grows over the ramp of the gait, and shrinks over one of the same length at the end.
#[derive(Debug, Clone, PartialEq)]
pub struct FoldedWalk {
    /// The legs that are folded, from 0.
    pub folded_legs: Vec<usize>,
    /// What the others walk: a motion of feet.
    pub gait: Gait,
    /// Step cycles from the first step until the stride begins to shrink.
    pub cycles: usize,
}

/// How legs are folded and unfolded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoldTiming {
    /// How long a leg takes; longer where its servos are too slow for that.
    pub fold_s: f64,
    /// How long the robot stands after each walk.
    pub stand_s: f64,
}

impl Default for FoldTiming {
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

impl JointTrajectory {
    /// The robot does one walk after the other, from the stance to the stance: it folds the legs,
    /// walks, unfolds them and stands for a moment. One row for each command of the servos.
    ///
    /// # Errors
    /// [`ModelError::Setting`] where a number makes no sense, a gait is no motion of feet, walks
    /// begin in different stances, a leg is not the robot's, or a joint would have to turn faster than
    /// its servo can; [`ModelError::LegCount`] and [`ModelError::Unreachable`] where gait and robot do
    /// not fit.
    pub fn of_folded_walks(
        robot: &Robot,
        walks: &[FoldedWalk],
        timing: FoldTiming,
    ) -> Result<Self, ModelError> {
        SettingError::check("fold_s", timing.fold_s, 0.0..=60.0, "s")?;
        SettingError::check("stand_s", timing.stand_s, 0.0..=60.0, "s")?;
        let hold_s = robot.servo().command_hold_s;
        let mut rows_rad: Vec<Vec<f64>> = Vec::new();
        for (index, walk) in walks.iter().enumerate() {
            let stance_rad = walk.angles_rad(robot, 0.0)?;
            match rows_rad.first() {
                None => rows_rad.push(stance_rad.clone()),
                Some(first) if furthest_rad(first, &stance_rad) > 1e-9 => {
                    let name = format!("walks[{index}].gait.body_height_m");
                    let found = walk.feet()?.body_height_m;
                    return Err(SettingError::new(name, found, "that of the first walk").into());
                }
                Some(_) => {}
            }
            let folded_rad = walk.with_folded(robot, stance_rad.clone());
            let fold_s = walk.fold_s(robot, &stance_rad, &folded_rad, timing);
            rows_rad.extend(least_jerk(&stance_rad, &folded_rad, fold_s, hold_s));
            let steps = rows(walk.walked_s()?, hold_s);
            for row in 1..=steps {
                let angles_rad = walk.angles_rad(robot, row as f64 * hold_s)?;
                rows_rad.push(walk.with_folded(robot, angles_rad));
            }
            rows_rad.extend(least_jerk(&folded_rad, &stance_rad, fold_s, hold_s));
            let standing = rows(timing.stand_s, hold_s);
            rows_rad.extend(std::iter::repeat_n(stance_rad, standing));
        }
        check_speed(robot, &rows_rad)?;
        Ok(Self::new(hold_s, rows_rad, None)?)
    }
}

impl FoldedWalk {
    fn feet(&self) -> Result<&FootMotion, SettingError> {
        let feet = self.gait.feet();
        feet.ok_or_else(|| SettingError::new("gait", &self.gait.name, "the motion of feet"))
    }

    /// From the first step to the last.
    fn walked_s(&self) -> Result<f64, SettingError> {
        Ok(self.cycles as f64 * self.gait.period_s + self.feet()?.ramp_s)
    }

    /// What the gait commands all legs so long after the first step; the stance after the last.
    fn angles_rad(&self, robot: &Robot, time_s: f64) -> Result<Vec<f64>, ModelError> {
        let strange = self.folded_legs.iter();
        let strange = strange.copied().find(|leg| *leg >= robot.legs().len());
        if let Some(leg) = strange {
            let expected = format!("legs of {}, from 0", robot.name());
            return Err(SettingError::new("folded_legs", leg, expected).into());
        }
        let feet = self.feet()?;
        if feet.phase_offsets.len() != robot.legs().len() {
            return Err(ModelError::LegCount {
                gait: feet.phase_offsets.len(),
                robot: robot.legs().len(),
            });
        }
        self.gait.check()?;
        let left_s = self.walked_s()? - time_s;
        let share = match left_s {
            left_s if left_s >= feet.ramp_s => 1.0,
            left_s => (left_s / feet.ramp_s).max(0.0),
        };
        let shrunk = FootMotion {
            stride_m: share * feet.stride_m,
            lift_m: share * feet.lift_m,
            ..feet.clone()
        };
        reaching(robot, &shrunk, self.gait.period_s, time_s)
    }

    /// The same where the folded legs are folded.
    fn with_folded(&self, robot: &Robot, mut angles_rad: Vec<f64>) -> Vec<f64> {
        let mut joint = 0;
        for (index, leg) in robot.legs().iter().enumerate() {
            for link in &leg.links {
                if let Some(angle_rad) = angles_rad.get_mut(joint)
                    && self.folded_legs.contains(&index)
                {
                    *angle_rad = link.locked_rad;
                }
                joint += 1;
            }
        }
        angles_rad
    }

    /// How long folding takes; 0 where no leg is folded.
    fn fold_s(
        &self,
        robot: &Robot,
        stance_rad: &[f64],
        folded_rad: &[f64],
        timing: FoldTiming,
    ) -> f64 {
        if self.folded_legs.is_empty() {
            return 0.0;
        }
        let furthest_rad = furthest_rad(stance_rad, folded_rad);
        let fastest_s = LEAST_JERK_PEAK * furthest_rad / robot.servo().speed_limit_rad_per_s;
        timing.fold_s.max(fastest_s)
    }
}

/// How many rows last so long at least.
fn rows(duration_s: f64, hold_s: f64) -> usize {
    (duration_s / hold_s - TOLERANCE).ceil().max(0.0) as usize
}

fn furthest_rad(from_rad: &[f64], to_rad: &[f64]) -> f64 {
    let each = from_rad
        .iter()
        .zip(to_rad)
        .map(|(from, to)| (to - from).abs());
    each.fold(0.0, f64::max)
}

/// Rows from one pose to another with the least jerk, without the first.
fn least_jerk(
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn tripod(stride: f64, lift: f64, period: f64) -> Gait {
        let mut gait = Gait::tripod();
        gait.period_s *= period;
        let feet = gait.feet_mut().unwrap();
        feet.stride_m *= stride;
        feet.lift_m *= lift;
        gait
    }

    fn walk(folded_legs: &[usize], gait: Gait, cycles: usize) -> FoldedWalk {
        FoldedWalk {
            folded_legs: folded_legs.to_vec(),
            gait,
            cycles,
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        #[test]
        fn walks_begin_and_end_in_the_stance_and_no_servo_is_too_slow(
            legs in prop::collection::vec(prop::collection::vec(0_usize..6, 0..3), 1..4),
            stride in 0.3..1.3_f64,
            lift in 0.5..1.3_f64,
            period in 0.9..1.6_f64,
            cycles in 1_usize..4,
            fold_s in 0.0..1.2_f64,
        ) {
            let robot = Robot::jethexa();
            let walks: Vec<_> = legs.iter().map(|legs| walk(legs, tripod(stride, lift, period), cycles)).collect();
            let timing = FoldTiming { fold_s, stand_s: 0.1 };
            let motion = JointTrajectory::of_folded_walks(&robot, &walks, timing);
            let most_rad = robot.servo().speed_limit_rad_per_s * robot.servo().command_hold_s;
            let gait = tripod(stride, lift, period);
            let plain = JointTrajectory::commanded(&robot, &gait, 3.0 * gait.period_s).unwrap();
            let fastest_rad = plain.rows_rad().windows(2).map(|pair| furthest_rad(&pair[0], &pair[1]));
            let fastest_rad = fastest_rad.fold(0.0, f64::max);
            let Ok(motion) = motion else {
                // Nothing but steps that are as fast by themselves is refused: the last ones, which
                // shrink, are a little faster.
                prop_assert!(fastest_rad > 0.95 * most_rad, "{motion:?}");
                return Ok(());
            };
            let rows = motion.rows_rad();
            let stance = JointTrajectory::commanded(&robot, &Gait::tripod(), 1.0).unwrap();
            prop_assert!(furthest_rad(&rows[0], &stance.rows_rad()[0]) < 1e-12);
            prop_assert!(furthest_rad(&rows[rows.len() - 1], &stance.rows_rad()[0]) < 1e-12);
            for pair in rows.windows(2) {
                prop_assert!(furthest_rad(&pair[0], &pair[1]) <= most_rad * 1.000_01);
            }
            prop_assert_eq!(motion.repeat_rows(), None);
        }
    }

    #[test]
    fn folded_legs_stay_folded_while_the_others_walk_as_the_gait_commands() {
        let robot = Robot::jethexa();
        let timing = FoldTiming::default();
        let (folded, cycles) = ([0, 3], 3);
        let walks = [walk(&folded, Gait::tripod(), cycles)];
        let motion = JointTrajectory::of_folded_walks(&robot, &walks, timing).unwrap();
        let plain = JointTrajectory::commanded(&robot, &Gait::tripod(), 4.0).unwrap();
        let fold_rows = rows(timing.fold_s, motion.row_s());
        // While the stride grows and is full, until it shrinks.
        for row in 0..=cycles * 50 {
            let (moved, commanded) = (&motion.rows_rad()[fold_rows + row], &plain.rows_rad()[row]);
            for (leg, described) in robot.legs().iter().enumerate() {
                for (joint, link) in described.links.iter().enumerate() {
                    let k = 3 * leg + joint;
                    let expected = match folded.contains(&leg) {
                        true => link.locked_rad,
                        false => commanded[k],
                    };
                    assert!((moved[k] - expected).abs() < 1e-12, "row {row} joint {k}");
                }
            }
        }
        // The control: before, the legs are on their way.
        assert!(motion.rows_rad()[fold_rows / 2][1] < robot.legs()[0].links[1].locked_rad - 0.1);
    }

    #[test]
    fn what_no_robot_can_do_is_refused() {
        let robot = Robot::jethexa();
        let message = |walks: &[FoldedWalk]| {
            let refused = JointTrajectory::of_folded_walks(&robot, walks, FoldTiming::default());
            refused.unwrap_err().to_string()
        };
        let strange = message(&[walk(&[6], Gait::tripod(), 1)]);
        assert!(strange.contains("folded_legs: 6"), "{strange}");
        let fast = message(&[walk(&[], tripod(1.0, 1.0, 0.3), 4)]);
        assert!(fast.contains("at most 5.2 rad/s"), "{fast}");
        let mut higher = Gait::tripod();
        higher.feet_mut().unwrap().body_height_m += 0.005;
        let steps = message(&[walk(&[], Gait::tripod(), 1), walk(&[], higher, 1)]);
        assert!(steps.contains("walks[1].gait.body_height_m"), "{steps}");
        assert!(message(&[]).contains("at least 2 rows"));
    }
}
