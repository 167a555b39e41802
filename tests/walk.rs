//! Simulated walks against MuJoCo (`tools/golden/mujoco_walk.py`): another
//! engine, another implementation of robot, gait and servo, the same facts.
//!
//! The engines' contact laws differ, so bodies fall and slip a little
//! differently. What must agree is the shape of roll and pitch, and how far the
//! robot turns.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use mlr_filter::Axes;
use mlr_golden_tests::angles;
use mlr_model::{Gait, Morphology, Outcome, Robot, SimulationSettings, Simulator};

const GOLDEN_STEP_S: f64 = 0.02;

fn walk(morphology: &str) -> Axes<Vec<f64>> {
    let robot = Robot::jethexa();
    let morphology = Morphology::parse(morphology, &robot.layout()).unwrap();
    let settings = SimulationSettings {
        time_step_s: 0.001,
        ..Default::default()
    };
    let simulator = Simulator::new(robot, &Gait::tripod(), settings).unwrap();
    let Outcome::Walked(trajectory) = simulator.simulate(&morphology) else {
        panic!("{morphology} diverged");
    };
    let every = (GOLDEN_STEP_S / 0.001).round() as usize;
    let angles = trajectory.orientation.angles_rad();
    angles
        .as_ref()
        .map(|_, samples| samples.iter().step_by(every).copied().collect())
}

fn mean_difference_deg(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let total: f64 = a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum();
    (total / a.len() as f64).to_degrees()
}

fn agrees_with_mujoco(morphology: &str, golden: &str) {
    let (ours, theirs) = (walk(morphology), angles(golden));
    let roll = mean_difference_deg(&ours.roll, &theirs.roll);
    let pitch = mean_difference_deg(&ours.pitch, &theirs.pitch);
    assert!(
        roll < 0.35 && pitch < 0.35,
        "{golden}: roll {roll}°, pitch {pitch}°"
    );
    let turned = |angles: &Axes<Vec<f64>>| angles.yaw.last().unwrap().to_degrees();
    let (ours, theirs) = (turned(&ours), turned(&theirs));
    assert!(
        (ours - theirs).abs() < 1.0 + 0.25 * theirs.abs(),
        "{golden}: yaw {ours}° against {theirs}°"
    );
}

#[test]
fn healthy() {
    agrees_with_mujoco("111 111 111 111 111 111", "golden/mujoco/healthy.csv");
}

#[test]
fn one_leg() {
    agrees_with_mujoco("111 111 000 111 111 111", "golden/mujoco/leg3-lost.csv");
}

#[test]
fn both_middle_legs() {
    agrees_with_mujoco("111 111 000 000 111 111", "golden/mujoco/legs3-4-lost.csv");
}

#[test]
fn two_legs_of_one_tripod() {
    agrees_with_mujoco("111 111 111 000 000 111", "golden/mujoco/legs4-5-lost.csv");
}

#[test]
fn two_last_links() {
    agrees_with_mujoco(
        "111 110 110 111 111 111",
        "golden/mujoco/legs2-3-tibia-lost.csv",
    );
}

#[test]
fn control_another_damage_does_not_agree() {
    let (ours, theirs) = (
        walk("111 000 111 111 111 111"),
        angles("golden/mujoco/leg3-lost.csv"),
    );
    assert!(mean_difference_deg(&ours.roll, &theirs.roll) > 1.0);
}
