//! A robot walks the same whichever way it heads: friction has no direction of its own.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use mlr_model::{Gait, Morphology, Outcome, Robot, SimulationSettings, Simulator, Terrain};

/// How far a robot turns in each cycle of the gait but the first two, degrees.
fn turns_deg(lost: &str, terrain: Terrain) -> Vec<f64> {
    let settings = SimulationSettings {
        duration_s: 9.0,
        terrain,
        ..SimulationSettings::default()
    };
    let robot = Robot::jethexa();
    let morphology = Morphology::parse_legs_lost(lost, &robot.layout()).unwrap();
    let simulator = Simulator::new(robot, &Gait::tripod(), settings).unwrap();
    let Outcome::Walked(walk) = simulator.simulate(&morphology) else {
        panic!("{lost} diverged");
    };
    let yaw_rad = &walk.orientation.angles_rad().yaw;
    let times_s = walk.orientation.times_s();
    let yaw_at = |time_s: f64| yaw_rad[times_s.partition_point(|t| *t < time_s - 1e-9)];
    (2..9)
        .map(|cycle| (yaw_at(f64::from(cycle) + 1.0) - yaw_at(f64::from(cycle))).to_degrees())
        .collect()
}

fn spread(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let off = values.iter().map(|value| (value - mean).abs());
    off.fold(0.0, f64::max) / mean.abs()
}

#[test]
fn a_robot_turns_by_the_same_in_every_cycle() {
    let slope = Terrain {
        slope_rad: 0.03,
        uphill_rad: 1.0,
        roughness: None,
    };
    for lost in ["3", "4", "5"] {
        let turns = turns_deg(lost, Terrain::default());
        assert!(turns.iter().sum::<f64>().abs() > 60.0, "{lost}: {turns:?}");
        assert!(spread(&turns) < 1e-3, "{lost}: {turns:?}");
        // The control: where a slope gives the ground a direction, the heading matters.
        let turns = turns_deg(lost, slope.clone());
        assert!(spread(&turns) > 1e-2, "{lost}: {turns:?}");
    }
}
