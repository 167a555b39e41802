//! Turning on the spot.

use mlr_filter::SettingError;
use nalgebra::{Point3, Vector3};

use super::{
    FootMotion, Gait,
    segment::{ending, feet_of, rows, walked_s},
};
use crate::{ModelError, Robot, joint_commands::reaching_targets, robot::rotation_about};

/// Some steps in which the robot turns on the spot: what tilts it from outside stays where it is, what
/// tilts its sensor turns with it.
///
/// Each foot goes to and fro on a circle about the body's vertical axis as the feet of the gait do on a
/// straight line. The angle of a step grows over the ramp of the gait, and shrinks over one of the same
/// length at the end.
#[derive(Debug, Clone, PartialEq)]
pub struct TurnInPlace {
    /// When the feet swing, and how high: a motion of feet. Its stride does not matter.
    pub gait: Gait,
    /// By how much each foot turns the body while it stands; positive to the left (REP-103).
    pub step_rad: f64,
    /// Step cycles from the first step until the steps begin to shrink.
    pub cycles: usize,
}

impl TurnInPlace {
    /// Rows from the stance to the stance.
    pub(super) fn rows_rad(&self, robot: &Robot) -> Result<Vec<Vec<f64>>, ModelError> {
        SettingError::check("step_rad", self.step_rad, -1.0..=1.0, "rad")?;
        let feet = feet_of(&self.gait, robot)?;
        // The place of a foot along a stride of so many meters is its angle on the circle.
        let feet = FootMotion {
            stride_m: self.step_rad,
            ..feet.clone()
        };
        let hold_s = robot.servo().command_hold_s;
        let period_s = self.gait.period_s;
        let walked_s = walked_s(&self.gait, &feet, self.cycles);
        let at = |time_s: f64| {
            let ending = ending(&feet, walked_s - time_s);
            reaching_targets(robot, time_s, |index, leg| {
                let [x_m, y_m] = leg.nominal_foot_m;
                let straight = ending.foot_target(period_s, index, leg, time_s);
                let turned = rotation_about(&Vector3::z(), straight.x - x_m);
                turned * Point3::new(x_m, y_m, straight.z)
            })
        };
        let count = rows(walked_s, hold_s);
        (0..=count).map(|row| at(row as f64 * hold_s)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Morphology, MotionSegment, Outcome, SimulationSettings, Simulator};

    /// How far a healthy robot turns, and how far it rolls and pitches at most.
    fn turned_deg(step_rad: f64, cycles: usize) -> [f64; 2] {
        let robot = Robot::jethexa();
        let turn = MotionSegment::Turn(TurnInPlace {
            gait: Gait::tripod(),
            step_rad,
            cycles,
        });
        let gait = Gait::of_segments("turn", 1.0, &robot, &[turn]).unwrap();
        let settings = SimulationSettings {
            duration_s: gait.duration_s().unwrap(),
            ..SimulationSettings::default()
        };
        let healthy = Morphology::healthy(&robot.layout());
        let simulator = Simulator::new(robot, &gait, settings).unwrap();
        let Outcome::Walked(walk) = simulator.simulate(&healthy) else {
            panic!("diverged");
        };
        let angles_rad = walk.orientation.angles_rad();
        let tilts = angles_rad.roll.iter().chain(&angles_rad.pitch);
        let most_rad = tilts.fold(0.0, |most: f64, tilt| most.max(tilt.abs()));
        [angles_rad.yaw[angles_rad.yaw.len() - 1], most_rad].map(f64::to_degrees)
    }

    #[test]
    fn a_robot_turns_by_two_steps_a_cycle_to_either_side_and_stays_level() {
        let [turned, tilt] = turned_deg(0.25, 3);
        // Two of three cycles are full ones, and two ramps of a cycle count half.
        let expected = 2.0 * 3.0 * 0.25_f64.to_degrees();
        assert!((turned / expected - 1.0).abs() < 0.1, "{turned} {expected}");
        assert!(tilt < 3.0, "{tilt}");
        let [back, _] = turned_deg(-0.25, 3);
        assert!((turned + back).abs() < 0.1 * turned, "{turned} {back}");
        // Control: steps on the spot.
        let [still, _] = turned_deg(0.0, 3);
        assert!(still.abs() < 3.0, "{still}");
    }

    #[test]
    fn a_turn_that_no_robot_makes_is_refused() {
        let turn = |step_rad| {
            let turn = TurnInPlace {
                gait: Gait::tripod(),
                step_rad,
                cycles: 1,
            };
            turn.rows_rad(&Robot::jethexa()).unwrap_err().to_string()
        };
        assert!(turn(3.0).contains("step_rad"));
        assert!(turn(f64::NAN).contains("step_rad"));
    }
}
