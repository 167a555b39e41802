//! Gaits of damaged robots, found with little effort.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use mlr_filter::DetectorSettings;
use mlr_model::{Gait, JointTrajectory, Morphology, Motion, Robot, SimulationSettings};
use mlr_recover::{
    Diagnosis, PossibleRobot, RecoverError, RecoverSettings, Recovery, Task, WhatIsLeft, recover,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

fn recovered(legs_lost: &str, generations: usize) -> Result<Recovery, RecoverError> {
    let robot = Robot::jethexa();
    let morphology = Morphology::parse_legs_lost(legs_lost, &robot.layout()).unwrap();
    let left = WhatIsLeft::of(morphology.clone());
    let possible = PossibleRobot {
        robot: robot.clone(),
        morphology,
        simulation: left.simulated(&SimulationSettings::default()),
    };
    let settings = RecoverSettings {
        screen_steps: 10_000,
        robots: 1,
        judged_robots: 1,
        generations,
        ..RecoverSettings::default()
    };
    let task = Task {
        robot: &robot,
        nominal: &Gait::tripod(),
        diagnosis: &Diagnosis::certain(left),
        robots: &[possible],
        detector: DetectorSettings::default(),
    };
    recover(task, &settings, &mut ChaCha8Rng::seed_from_u64(1), &())
}

fn joints(found: &Recovery) -> &JointTrajectory {
    match &found.gait.motion {
        Motion::Joints(joints) => joints,
        Motion::Feet(feet) => panic!("{feet:?}"),
    }
}

#[test]
fn a_robot_without_its_middle_legs_walks_again() {
    let found = recovered("3,4", 2).unwrap();
    assert_eq!(found.plan.walking(), [0, 1, 4, 5]);
    assert!(found.margin_m > 0.003, "{}", found.margin_m);
    assert!(found.first_steps_margin_m > 0.003);
    let [before, after] = [&found.before, &found.after].map(|outlook| outlook.walks[0].unwrap());
    assert!(before.fluctuation_deg > 5.0, "{before:?}");
    assert!(after.fluctuation_deg < 4.0, "{after:?}");
    assert!(found.first_steps_fluctuation_deg < 5.0);
    // It gets as far as planned, which no robot does whose feet slip.
    let planned = found.plan.speed_m_per_s();
    assert!(
        (after.speed_m_per_s / planned - 1.0).abs() < 0.15,
        "{after:?} {planned}"
    );
    assert!(after.drift_deg_per_m.abs() < before.drift_deg_per_m.abs());
    assert!(found.after.calm_probability > 0.8 && found.before.calm_probability < 0.5);

    // From the nominal stance, never faster than the servos, and into a cycle that repeats.
    let joints = joints(&found);
    let robot = Robot::jethexa();
    let stance = JointTrajectory::commanded(&robot, &Gait::tripod(), 1.0).unwrap();
    let rows = joints.rows_rad();
    for (angle, stood) in rows[0].iter().zip(&stance.rows_rad()[0]) {
        assert!((angle - stood).abs() < 1e-12);
    }
    let repeated = joints.repeat_rows().unwrap();
    assert_eq!(repeated.end, rows.len());
    let closing = [rows[repeated.end - 1].clone(), rows[repeated.start].clone()];
    let most_rad = robot.servo().speed_limit_rad_per_s * joints.row_s();
    for pair in rows.windows(2).chain([&closing[..]]) {
        let turned = pair[0].iter().zip(&pair[1]).map(|(a, b)| (b - a).abs());
        assert!(turned.fold(0.0, f64::max) <= most_rad);
    }
    found.gait.check().unwrap();
    // The same seed, the same gait.
    assert_eq!(recovered("3,4", 2).unwrap().gait, found.gait);
}

#[test]
fn where_nothing_stands_there_is_a_limp() {
    let found = recovered("1,3,5", 0).unwrap();
    assert!(found.margin_m <= 0.0);
    assert_eq!(found.plan.walking(), [1, 3, 5]);
    assert!(found.after.reliable_speed_m_per_s >= 0.0);
    let refused = recovered("1,2,3,4,5", 0).unwrap_err();
    assert!(matches!(refused, RecoverError::TooFewLegs(1)), "{refused}");
}
