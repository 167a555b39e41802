//! Nothing assumes six legs of three links: a quadruped whose front legs have
//! two links and whose rear legs have three.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use mlr_model::{
    Gait, Morphology, Outcome, Record, Robot, SimulationSettings, Simulator, Trajectory,
};

const ROBOT: &str = include_str!("quadruped.toml");

/// A walk that moves one foot at a time.
const GAIT: &str = r#"
name = "crawl"
period_s = 1.0
ramp_s = 1.0
stride_m = 0.04
lift_m = 0.02
body_height_m = 0.16
swing_fraction = 0.25
phase_offsets = [0.0, 0.5, 0.25, 0.75]
"#;

fn walk(morphology: &str) -> Trajectory {
    let robot = Robot::from_toml(ROBOT).unwrap();
    let morphology = Morphology::parse(morphology, &robot.layout()).unwrap();
    let settings = SimulationSettings {
        duration_s: 3.0,
        record: Record {
            position: true,
            ..Default::default()
        },
        ..Default::default()
    };
    let simulator = Simulator::new(robot, &Gait::from_toml(GAIT).unwrap(), settings).unwrap();
    match simulator.simulate(&morphology) {
        Outcome::Walked(trajectory) => trajectory,
        Outcome::Diverged { at_s } => panic!("diverged at {at_s} s"),
    }
}

#[test]
fn has_its_own_morphologies() {
    let layout = Robot::from_toml(ROBOT).unwrap().layout();
    assert_eq!(layout.total_links(), 10);
    assert_eq!(layout.count(), Some(3 * 3 * 4 * 4));
    assert_eq!(layout.enumerate().count(), 144);
}

#[test]
fn walks_forward_and_stays_upright() {
    let walked = walk("11 11 111 111");
    let [x_m, _, z_m] = *walked.position_m.unwrap().last().unwrap();
    assert!(x_m > 0.03, "walked {x_m} m");
    assert!(z_m > 0.12, "body at {z_m} m");
    let angles = walked.orientation.angles_rad();
    assert!(angles.roll.iter().all(|roll| roll.abs() < 0.35));
}

#[test]
fn moves_differently_without_a_leg() {
    let (whole, damaged) = (walk("11 11 111 111"), walk("00 11 111 111"));
    let (ours, theirs) = (
        whole.orientation.angles_rad(),
        damaged.orientation.angles_rad(),
    );
    let apart_rad = [
        (&ours.roll, &theirs.roll),
        (&ours.pitch, &theirs.pitch),
        (&ours.yaw, &theirs.yaw),
    ]
    .iter()
    .flat_map(|(a, b)| a.iter().zip(b.iter()))
    .fold(0.0_f64, |largest, (a, b)| largest.max((a - b).abs()));
    assert!(apart_rad > 0.05, "{apart_rad} rad apart");
}
