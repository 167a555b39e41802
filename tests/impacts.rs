//! A robot that falls on its nose, against MuJoCo (`tools/golden/mujoco_walk.py`): where impacts are compliant,
//! it rocks on its front edge as far as there, and where they are rigid by less than two degrees.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use mlr_golden_tests::columns;
use mlr_model::{
    Gait, GroundContact, Impacts, LostLinks, Morphology, Outcome, Robot, SimulationSettings,
    Simulator,
};

const FALL_S: f64 = 1.4;

/// Pitch of a robot whose front legs are locked in the air, from where it is set down, degrees.
fn fall_deg(impacts: Impacts, time_step_s: f64) -> Vec<f64> {
    let settings = SimulationSettings {
        settle_s: 0.0,
        stand_s: FALL_S,
        duration_s: 0.1,
        time_step_s,
        lost_links: LostLinks::Locked,
        contact: GroundContact::default().with_impacts(impacts),
        ..SimulationSettings::default()
    };
    let robot = Robot::jethexa();
    let morphology = Morphology::parse_legs_lost("1,2", &robot.layout()).unwrap();
    let simulator = Simulator::new(robot, &Gait::tripod(), settings).unwrap();
    let Outcome::Walked(trajectory) = simulator.simulate(&morphology) else {
        panic!("the fall diverged");
    };
    let pitch = &trajectory.orientation.angles_rad().pitch;
    pitch.iter().map(|pitch| pitch.to_degrees()).collect()
}

/// How far it falls, and how far it rocks beyond where it comes to rest.
fn fallen_and_rocked_deg(pitch_deg: &[f64]) -> (f64, f64) {
    let rest_deg = *pitch_deg.last().unwrap();
    let farthest_deg = pitch_deg.iter().copied().fold(0.0, f64::max);
    (rest_deg, farthest_deg - rest_deg)
}

#[test]
fn a_robot_that_falls_on_its_nose_rocks_on_it() {
    let [_, golden_rad] = columns("golden/mujoco/nose-fall.csv", ["t_s", "pitch_rad"]);
    let golden: Vec<f64> = golden_rad.iter().map(|pitch| pitch.to_degrees()).collect();
    let (rest_deg, rocked_deg) = fallen_and_rocked_deg(&golden);
    for time_step_s in [0.001, 0.010] {
        let of = |impacts| fallen_and_rocked_deg(&fall_deg(impacts, time_step_s));
        let (compliant, rigid) = (of(Impacts::Compliant), of(Impacts::Rigid));
        println!("{time_step_s}: {compliant:?} {rigid:?}, MuJoCo {rest_deg} {rocked_deg}");
        for (rest, _) in [compliant, rigid] {
            assert!((rest - rest_deg).abs() < 1.0, "{rest} {rest_deg}");
        }
        assert!(
            (compliant.1 / rocked_deg - 1.0).abs() < 0.3,
            "{compliant:?} {rocked_deg}"
        );
        // The control.
        assert!(rigid.1 < 0.4 * rocked_deg, "{rigid:?} {rocked_deg}");
    }
}

#[test]
fn where_nothing_falls_impacts_change_little() {
    let walk = |impacts, lost: &str| {
        let settings = SimulationSettings {
            contact: GroundContact::default().with_impacts(impacts),
            ..SimulationSettings::default()
        };
        let robot = Robot::jethexa();
        let morphology = Morphology::parse_legs_lost(lost, &robot.layout()).unwrap();
        let simulator = Simulator::new(robot, &Gait::tripod(), settings).unwrap();
        let Outcome::Walked(trajectory) = simulator.simulate(&morphology) else {
            panic!("the walk diverged");
        };
        trajectory.orientation.angles_rad().roll.clone()
    };
    let apart_deg = |lost: &str| {
        let (rigid, compliant) = (walk(Impacts::Rigid, lost), walk(Impacts::Compliant, lost));
        let squares = rigid.iter().zip(&compliant).map(|(a, b)| (a - b).powi(2));
        (squares.sum::<f64>() / rigid.len() as f64)
            .sqrt()
            .to_degrees()
    };
    assert!(apart_deg("") < 0.1, "{}", apart_deg(""));
    assert!(apart_deg("3,4") < 0.1, "{}", apart_deg("3,4"));
    // The control: a robot that falls on a corner of its body in every step.
    assert!(apart_deg("1") > 0.1, "{}", apart_deg("1"));
}
