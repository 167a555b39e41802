//! Walks with legs folded on command, one after the other.

use super::{
    Gait,
    segment::{SegmentTiming, check_leg, ending, feet_of, least_jerk, least_s, rows, walked_s},
};
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

impl FoldedWalk {
    /// Rows from the stance to the stance: the legs are folded, the others walk, and the legs are
    /// unfolded.
    pub(super) fn rows_rad(
        &self,
        robot: &Robot,
        timing: SegmentTiming,
    ) -> Result<Vec<Vec<f64>>, ModelError> {
        for leg in &self.folded_legs {
            check_leg("folded_legs", *leg, robot)?;
        }
        let hold_s = robot.servo().command_hold_s;
        let stance_rad = self.angles_rad(robot, 0.0)?;
        let folded_rad = self.with_folded(robot, stance_rad.clone());
        let fold_s = match self.folded_legs.is_empty() {
            true => 0.0,
            false => least_s(robot, &stance_rad, &folded_rad, timing.fold_s),
        };
        let mut rows_rad = vec![stance_rad.clone()];
        rows_rad.extend(least_jerk(&stance_rad, &folded_rad, fold_s, hold_s));
        let walked_s = walked_s(&self.gait, feet_of(&self.gait, robot)?, self.cycles);
        for row in 1..=rows(walked_s, hold_s) {
            let angles_rad = self.angles_rad(robot, row as f64 * hold_s)?;
            rows_rad.push(self.with_folded(robot, angles_rad));
        }
        rows_rad.extend(least_jerk(&folded_rad, &stance_rad, fold_s, hold_s));
        Ok(rows_rad)
    }

    /// What the gait commands all legs so long after the first step; the stance after the last.
    fn angles_rad(&self, robot: &Robot, time_s: f64) -> Result<Vec<f64>, ModelError> {
        let feet = feet_of(&self.gait, robot)?;
        let ending = ending(feet, walked_s(&self.gait, feet, self.cycles) - time_s);
        reaching(robot, &ending, self.gait.period_s, time_s)
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
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{super::segment::furthest_rad, *};
    use crate::{JointTrajectory, MotionSegment};

    fn tripod(stride: f64, lift: f64, period: f64) -> Gait {
        let mut gait = Gait::tripod();
        gait.period_s *= period;
        let feet = gait.feet_mut().unwrap();
        feet.stride_m *= stride;
        feet.lift_m *= lift;
        gait
    }

    fn walk(folded_legs: &[usize], gait: Gait, cycles: usize) -> MotionSegment {
        MotionSegment::Walk(FoldedWalk {
            folded_legs: folded_legs.to_vec(),
            gait,
            cycles,
        })
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
            let timing = SegmentTiming { fold_s, stand_s: 0.1 };
            let motion = JointTrajectory::of_segments(&robot, &walks, timing);
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
        let timing = SegmentTiming::default();
        let (folded, cycles) = ([0, 3], 3);
        let walks = [walk(&folded, Gait::tripod(), cycles)];
        let motion = JointTrajectory::of_segments(&robot, &walks, timing).unwrap();
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
        let message = |walks: &[MotionSegment]| {
            let refused = JointTrajectory::of_segments(&robot, walks, SegmentTiming::default());
            refused.unwrap_err().to_string()
        };
        let strange = message(&[walk(&[6], Gait::tripod(), 1)]);
        assert!(strange.contains("folded_legs: 6"), "{strange}");
        let fast = message(&[walk(&[], tripod(1.0, 1.0, 0.3), 4)]);
        assert!(fast.contains("at most 5.2 rad/s"), "{fast}");
        let mut higher = Gait::tripod();
        higher.feet_mut().unwrap().body_height_m += 0.005;
        let steps = message(&[walk(&[], Gait::tripod(), 1), walk(&[], higher, 1)]);
        assert!(steps.contains("segments[1]"), "{steps}");
        assert!(message(&[]).contains("at least 2 rows"));
    }
}
