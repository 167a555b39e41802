//! Motions of a body whose feet stay where they are.

use mlr_filter::SettingError;
use nalgebra::Vector3;

use super::{
    FootTarget, Gait,
    segment::{SegmentTiming, check_leg, feet_of, least_jerk, least_s, rows},
};
use crate::{ModelError, Robot, joint_commands::reaching_targets, robot::rotation_about};

/// One leg presses on the ground while the body is low.
///
/// The body is lowered while the leg takes its pose, one of its joints still as in the stance. Then this
/// joint goes to its angle, stays there and comes back, some times; what of the leg is long enough
/// reaches the ground and tilts the body.
#[derive(Debug, Clone, PartialEq)]
pub struct LegPress {
    /// Its feet stand where those of this gait do, a motion of feet.
    pub gait: Gait,
    /// The leg that presses, from 0.
    pub leg: usize,
    /// Its pose, from the body outward.
    pub pose_rad: Vec<f64>,
    /// The joint that presses, from 0: the others keep their angles.
    pub joint: usize,
    /// How far the body is lowered.
    pub lowered_m: f64,
    /// How long pressing takes, and how long coming back.
    pub press_s: f64,
    /// How long the leg presses.
    pub hold_s: f64,
    /// How often.
    pub times: usize,
}

/// The body rolls to one side and back, once: a log shows when it begins.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyNod {
    /// Its feet stand where those of this gait do, a motion of feet.
    pub gait: Gait,
    /// How far; positive to the right (REP-103).
    pub roll_rad: f64,
    /// How long it takes, and how long coming back.
    pub nod_s: f64,
}

impl LegPress {
    /// Rows from the stance to the stance.
    pub(super) fn rows_rad(
        &self,
        robot: &Robot,
        timing: SegmentTiming,
    ) -> Result<Vec<Vec<f64>>, ModelError> {
        check_leg("leg", self.leg, robot)?;
        let joints = robot.legs()[self.leg].links.len();
        if self.pose_rad.len() != joints {
            let expected = format!("{joints} angles");
            return Err(SettingError::new("pose_rad", self.pose_rad.len(), expected).into());
        }
        if self.joint >= joints {
            let expected = format!("a joint from 0 to {}", joints - 1);
            return Err(SettingError::new("joint", self.joint, expected).into());
        }
        SettingError::check_each("pose_rad", &self.pose_rad, -3.2..=3.2, "rad")?;
        SettingError::check("press_s", self.press_s, 0.0..=60.0, "s")?;
        SettingError::check("hold_s", self.hold_s, 0.0..=60.0, "s")?;
        let down = Vector3::new(0.0, 0.0, self.lowered_m);
        let stance_rad = standing_rad(robot, &self.gait, |foot| foot)?;
        let low_rad = standing_rad(robot, &self.gait, |foot| foot + down)?;
        let first: usize = robot.legs()[..self.leg]
            .iter()
            .map(|leg| leg.links.len())
            .sum();
        let mut pressing_rad = low_rad;
        pressing_rad[first..first + joints].copy_from_slice(&self.pose_rad);
        let mut ready_rad = pressing_rad.clone();
        ready_rad[first + self.joint] = stance_rad[first + self.joint];
        let hold_s = robot.servo().command_hold_s;
        let change_s = least_s(robot, &stance_rad, &ready_rad, timing.fold_s);
        let press_s = least_s(robot, &ready_rad, &pressing_rad, self.press_s);
        let mut rows_rad = vec![stance_rad.clone()];
        rows_rad.extend(least_jerk(&stance_rad, &ready_rad, change_s, hold_s));
        for _ in 0..self.times {
            rows_rad.extend(least_jerk(&ready_rad, &pressing_rad, press_s, hold_s));
            let held = rows(self.hold_s, hold_s);
            rows_rad.extend(std::iter::repeat_n(pressing_rad.clone(), held));
            rows_rad.extend(least_jerk(&pressing_rad, &ready_rad, press_s, hold_s));
        }
        rows_rad.extend(least_jerk(&ready_rad, &stance_rad, change_s, hold_s));
        Ok(rows_rad)
    }
}

impl BodyNod {
    /// Rows from the stance to the stance.
    pub(super) fn rows_rad(&self, robot: &Robot) -> Result<Vec<Vec<f64>>, ModelError> {
        SettingError::check("roll_rad", self.roll_rad, -0.5..=0.5, "rad")?;
        SettingError::check("nod_s", self.nod_s, 0.0..=60.0, "s")?;
        let rolled = rotation_about(&Vector3::x(), -self.roll_rad);
        let stance_rad = standing_rad(robot, &self.gait, |foot| foot)?;
        let rolled_rad = standing_rad(robot, &self.gait, |foot| rolled * foot)?;
        let hold_s = robot.servo().command_hold_s;
        let nod_s = least_s(robot, &stance_rad, &rolled_rad, self.nod_s);
        let mut rows_rad = vec![stance_rad.clone()];
        rows_rad.extend(least_jerk(&stance_rad, &rolled_rad, nod_s, hold_s));
        rows_rad.extend(least_jerk(&rolled_rad, &stance_rad, nod_s, hold_s));
        Ok(rows_rad)
    }
}

/// Angles of all joints where every foot of the stance is moved as said, in the body frame.
fn standing_rad(
    robot: &Robot,
    gait: &Gait,
    moved: impl Fn(FootTarget) -> FootTarget,
) -> Result<Vec<f64>, ModelError> {
    let feet = feet_of(gait, robot)?;
    reaching_targets(robot, 0.0, |index, leg| {
        moved(feet.foot_target(gait.period_s, index, leg, 0.0))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LostLinks, Morphology, MotionSegment, Outcome, SimulationSettings, Simulator};

    fn press(leg: usize, femur_deg: f64) -> MotionSegment {
        MotionSegment::Press(LegPress {
            gait: Gait::tripod(),
            leg,
            pose_rad: vec![0.0, femur_deg.to_radians(), 110_f64.to_radians()],
            joint: 1,
            lowered_m: 0.03,
            press_s: 0.5,
            hold_s: 0.3,
            times: 1,
        })
    }

    fn nod(roll_rad: f64) -> MotionSegment {
        MotionSegment::Nod(BodyNod {
            gait: Gait::tripod(),
            roll_rad,
            nod_s: 0.3,
        })
    }

    /// The largest roll either way while a robot moves so.
    fn largest_roll_deg(segment: MotionSegment, morphology: &str, lost_links: LostLinks) -> f64 {
        let robot = Robot::jethexa();
        let gait = Gait::of_segments("test", 1.0, &robot, &[segment]).unwrap();
        let settings = SimulationSettings {
            duration_s: gait.duration_s().unwrap(),
            lost_links,
            ..SimulationSettings::default()
        };
        let morphology = Morphology::parse(morphology, &robot.layout()).unwrap();
        let simulator = Simulator::new(robot, &gait, settings).unwrap();
        let Outcome::Walked(walk) = simulator.simulate(&morphology) else {
            panic!("diverged");
        };
        let rolls_rad = &walk.orientation.angles_rad().roll;
        let furthest = rolls_rad.iter().max_by(|a, b| a.abs().total_cmp(&b.abs()));
        furthest.unwrap().to_degrees()
    }

    #[test]
    fn the_body_rolls_as_far_as_it_nods() {
        let healthy = "111 111 111 111 111 111";
        for roll_deg in [3.0_f64, -3.0] {
            let rolled_deg =
                largest_roll_deg(nod(roll_deg.to_radians()), healthy, LostLinks::Absent);
            assert!((rolled_deg - roll_deg).abs() < 0.7, "{rolled_deg}");
        }
    }

    /// The middle left leg presses with the end of its femur; without a femur nothing happens.
    #[test]
    fn what_is_left_of_a_leg_tilts_the_body_when_it_presses() {
        let deep = || press(2, -60.0);
        let stump_deg = largest_roll_deg(deep(), "111 111 110 111 111 111", LostLinks::Absent);
        let none_deg = largest_roll_deg(deep(), "111 111 100 111 111 111", LostLinks::Absent);
        assert!(stump_deg > 2.0, "{stump_deg}");
        assert!(none_deg.abs() < 0.5, "{none_deg}");
        // A tibia that is locked straight out reaches the ground long before the femur does.
        let shallow = || press(2, -25.0);
        let straight_deg =
            largest_roll_deg(shallow(), "111 111 110 111 111 111", LostLinks::Locked);
        let stump_deg = largest_roll_deg(shallow(), "111 111 110 111 111 111", LostLinks::Absent);
        assert!(straight_deg > 2.0, "{straight_deg}");
        assert!(stump_deg.abs() < 0.5, "{stump_deg}");
    }

    #[test]
    fn what_no_robot_can_do_is_refused() {
        let robot = Robot::jethexa();
        let message = |segment: MotionSegment| {
            let refused = Gait::of_segments("test", 1.0, &robot, &[segment]);
            refused.unwrap_err().to_string()
        };
        let MotionSegment::Press(plain) = press(0, -60.0) else {
            panic!("not a press");
        };
        let with = |change: &dyn Fn(&mut LegPress)| {
            let mut press = plain.clone();
            change(&mut press);
            message(MotionSegment::Press(press))
        };
        assert!(with(&|one| one.leg = 6).contains("leg: 6"));
        assert!(with(&|one| one.joint = 3).contains("joint: 3"));
        assert!(with(&|one| one.pose_rad.truncate(2)).contains("3 angles"));
        assert!(with(&|one| one.lowered_m = -0.2).contains("reach"));
        assert!(message(nod(1.0)).contains("roll_rad"));
    }
}
