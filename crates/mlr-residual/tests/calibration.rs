//! Walks of the model itself, with parameters that the model is not told of.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use mlr_filter::{Axes, OrientationSeries};
use mlr_model::{
    Gait, GroundContact, Morphology, Outcome, Robot, RobotParameter, SimulationSettings, Simulator,
};
use mlr_residual::walk::{
    CalibratedRobot, EvidenceSettings, WalkModel, WalkRecord, calibrate_walk,
};
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// What the sensor of this robot reports on a ground of this friction, with 0.02° of noise: it stands
/// for two seconds and walks for eight.
fn recorded(robot: &Robot, friction: f64) -> WalkRecord {
    let settings = SimulationSettings {
        duration_s: 8.0,
        stand_s: 2.0,
        contact: GroundContact {
            friction,
            ..GroundContact::default()
        },
        ..SimulationSettings::default()
    };
    let healthy = Morphology::healthy(&robot.layout());
    let simulator = Simulator::new(robot.clone(), &Gait::tripod(), settings).unwrap();
    let Outcome::Walked(walk) = simulator.simulate(&healthy) else {
        panic!("diverged");
    };
    let seen = robot.imu().on(&walk.orientation);
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut noisy = |angles_rad: &[f64]| -> Vec<f64> {
        let noise = |x: &f64| x + 0.02_f64.to_radians() * 3.4 * (random.random::<f64>() - 0.5);
        angles_rad.iter().map(noise).collect()
    };
    let axes = seen.angles_rad();
    let angles_rad = Axes {
        roll: noisy(&axes.roll),
        pitch: noisy(&axes.pitch),
        yaw: noisy(&axes.yaw),
    };
    let recording = OrientationSeries::new(seen.times_s().to_vec(), angles_rad).unwrap();
    WalkRecord::new(&recording, 0.0, false, 0.0, Some([0.0; 3])).unwrap()
}

fn calibrated(known: &Robot, record: &WalkRecord) -> CalibratedRobot {
    let simulation = SimulationSettings::default();
    let nominal = WalkModel::nominal(known.clone(), Gait::tripod(), simulation);
    let generator = ChaCha8Rng::seed_from_u64(1);
    calibrate_walk(
        record,
        &nominal,
        &EvidenceSettings::default(),
        &generator,
        &(),
    )
    .unwrap()
}

/// Femurs 1 and 6 sit a degree off, the servos are softer, the sensor is tilted.
const OWN: [(RobotParameter, f64); 4] = [
    (RobotParameter::JointZero { leg: 0, joint: 1 }, 0.02),
    (RobotParameter::JointZero { leg: 5, joint: 1 }, -0.02),
    (RobotParameter::ServoStiffness, -0.15),
    (RobotParameter::ImuMounting(0), 1.0),
];

fn deviation(robot: &Robot, parameter: RobotParameter) -> f64 {
    let known = robot.calibration().unwrap();
    let row = known.row(parameter).unwrap();
    known.physical().covariance[(row, row)].sqrt()
}

#[test]
fn a_robot_is_known_by_its_walks() {
    let described = Robot::jethexa();
    let own = OWN.iter().fold(described.clone(), |robot, (one, by)| {
        robot.with_added(*one, *by)
    });
    let first = calibrated(&described, &recorded(&own, 0.7));
    let error = |found: &CalibratedRobot| {
        (
            found.error_before.validation_deg,
            found.error_after.validation_deg,
        )
    };
    let (before_deg, after_deg) = error(&first);
    assert!(after_deg < 0.2 * before_deg, "{before_deg} {after_deg}");
    for (parameter, _) in OWN {
        let make = EvidenceSettings::default().nuisance.of_make(parameter);
        let known = first.robot.calibration().unwrap();
        let mean = known.physical().mean[known.row(parameter).unwrap()];
        let off = (mean - parameter.coordinate(&own)).abs() / deviation(&first.robot, parameter);
        assert!(off < 2.5, "{parameter}: {off} deviations off");
        assert!(deviation(&first.robot, parameter) < make, "{parameter}");
    }
    // Another walk on other ground: what is known already explains most of it, and more is known then.
    let second = calibrated(&first.robot, &recorded(&own, 0.75));
    let (known_deg, _) = error(&second);
    assert!(known_deg < 0.4 * before_deg, "{before_deg} {known_deg}");
    for (parameter, _) in OWN {
        let (once, twice) = (&first.robot, &second.robot);
        assert!(
            deviation(twice, parameter) < deviation(once, parameter),
            "{parameter}"
        );
    }
    assert!(second.day.contains_key("friction") && !second.day.contains_key("stiffness"));
}

#[test]
fn a_robot_as_described_stays_as_described() {
    let described = Robot::jethexa();
    let found = calibrated(&described, &recorded(&described, 0.7));
    for parameter in found.robot.calibration().unwrap().parameters() {
        let make = EvidenceSettings::default().nuisance.of_make(*parameter);
        let moved = parameter.coordinate(&found.robot) - parameter.coordinate(&described);
        assert!(moved.abs() < 0.4 * make, "{parameter}: {moved}");
    }
}
