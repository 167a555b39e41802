//! What the walk before damage in mid-walk tells of its robot.

use mlr_imu::Recording;
use mlr_model::Robot;
use mlr_residual::Progress;

use super::ExplainSettings;
use crate::{HealthyWalk, MeasuredWalk, Model, calibrate, calibrate::unusual};

/// The part of a log in which its robot was healthy, and the robot that it tells of.
#[derive(Debug)]
pub(super) struct HealthyStretch {
    /// Log times of its walk.
    pub(super) stretch_s: [f64; 2],
    /// The robot with its own parameters.
    pub(super) robot: Robot,
}

/// Calibrates the robot by its walk before it was damaged.
///
/// # Errors
/// Why that walk tells nothing that can be used, for people.
pub(super) fn calibrated(
    recording: &Recording,
    measured: &MeasuredWalk,
    until_s: f64,
    model: Model<'_>,
    settings: ExplainSettings<'_>,
    progress: &(impl Progress + crate::Progress),
) -> Result<HealthyStretch, String> {
    let healthy = recording.before(until_s);
    let walk = HealthyWalk {
        recording: &healthy,
        gait: model.gait,
    };
    let calibrated = calibrate(&[walk], model.robot, settings, false, progress);
    let calibrated = calibrated.map_err(|(_, error)| error.to_string())?;
    // What makes it differ so much is an effect to be found.
    if let Some(error) = calibrated.walks.iter().find_map(unusual) {
        return Err(error.to_string());
    }
    Ok(HealthyStretch {
        stretch_s: [measured.start().start_s, until_s],
        robot: calibrated.robot,
    })
}

#[cfg(test)]
mod tests {
    use mlr_filter::{Axes, OrientationSeries};
    use mlr_model::{Gait, Morphology, Outcome, RobotParameter, SimulationSettings, Simulator};
    use mlr_residual::walk::EvidenceSettings;

    use super::*;
    use crate::{GaitPhase, IdentifySettings, WalkStart};

    const ROLL: RobotParameter = RobotParameter::ImuMounting(0);
    /// It stands for a second, walks for nine, and walks on without leg 3.
    const DAMAGED_S: f64 = 9.0;

    fn walk(robot: &Robot, legs_lost: &str) -> OrientationSeries {
        let settings = SimulationSettings {
            stand_s: 1.0,
            duration_s: 17.0,
            ..SimulationSettings::default()
        };
        let layout = robot.layout();
        let morphology = match legs_lost {
            "" => Morphology::healthy(&layout),
            legs => Morphology::parse_legs_lost(legs, &layout).unwrap(),
        };
        let simulator = Simulator::new(robot.clone(), &Gait::tripod(), settings).unwrap();
        let Outcome::Walked(walked) = simulator.simulate(&morphology) else {
            panic!("diverged");
        };
        robot.imu().on(&walked.orientation)
    }

    /// A log of such a robot. The damaged robot's heading goes on where the whole one's was.
    fn recorded(robot: &Robot) -> Recording {
        let (whole, damaged) = (walk(robot, ""), walk(robot, "3"));
        let times_s = whole.times_s();
        let first_damaged = times_s.partition_point(|t| *t < DAMAGED_S);
        let [of_whole, of_damaged] = [&whole, &damaged].map(OrientationSeries::angles_rad);
        let turned = of_whole.yaw[first_damaged] - of_damaged.yaw[first_damaged];
        let joined = |whole: &[f64], damaged: &[f64], added: f64| -> Vec<f64> {
            let damaged = damaged[first_damaged..].iter().map(|angle| angle + added);
            whole[..first_damaged]
                .iter()
                .copied()
                .chain(damaged)
                .collect()
        };
        let angles_rad = Axes {
            roll: joined(&of_whole.roll, &of_damaged.roll, 0.0),
            pitch: joined(&of_whole.pitch, &of_damaged.pitch, 0.0),
            yaw: joined(&of_whole.yaw, &of_damaged.yaw, turned),
        };
        let joined = OrientationSeries::new(times_s.to_vec(), angles_rad);
        joined.unwrap().into()
    }

    /// What the walk before the damage tells of a robot whose sensor is tilted by so much.
    fn told(tilt_deg: f64) -> Result<HealthyStretch, String> {
        let tilted = Robot::jethexa().with_added(ROLL, tilt_deg);
        let recording = recorded(&tilted);
        let (robot, gait) = (Robot::jethexa(), Gait::tripod());
        let identify = IdentifySettings {
            walk_start: WalkStart::CommandedAtS(0.0),
            ..IdentifySettings::default()
        };
        let measured = MeasuredWalk::new(&recording, &gait, &identify).unwrap();
        let phase = measured.phase();
        assert!(matches!(phase, GaitPhase::Elapsed { .. }), "{phase:?}");
        let until_s = measured.unchanged_until_s().unwrap();
        assert!((6.0..=DAMAGED_S).contains(&until_s), "{until_s}");
        let how = ExplainSettings {
            identify: &identify,
            explanation: &EvidenceSettings::default(),
        };
        let model = Model::new(&robot, &gait);
        calibrated(&recording, &measured, until_s, model, how, &())
    }

    #[test]
    fn the_walk_before_damage_tells_of_the_robot() {
        let told = told(1.0).unwrap();
        assert_eq!(told.stretch_s[0], 0.0);
        let described = ROLL.coordinate(&Robot::jethexa());
        let found_deg = ROLL.coordinate(&told.robot) - described;
        assert!((found_deg - 1.0).abs() < 0.3, "{found_deg}");
        assert!(told.robot.calibration().is_some());
    }

    #[test]
    fn a_robot_that_was_unlike_any_healthy_one_is_not_taken_as_it_is() {
        // Ten deviations of the make: somebody knocked the sensor.
        let reason = told(6.0).unwrap_err();
        assert!(reason.contains("something is wrong"), "{reason}");
    }
}
