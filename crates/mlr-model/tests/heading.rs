//! Walks whose physics turns with the robot, with the physics that stays as control.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use mlr_model::{
    Fault, Gait, Morphology, Outcome, Record, Robot, SimulationSettings, Simulator, Terrain,
    Trajectory,
};

fn walk(lost: &str, settings: SimulationSettings, following: bool) -> Trajectory {
    let settings = SimulationSettings {
        duration_s: 9.0,
        record: Record {
            position: true,
            ..Record::default()
        },
        ..settings
    };
    let robot = Robot::jethexa();
    let morphology = Morphology::parse_legs_lost(lost, &robot.layout()).unwrap();
    let mut simulator = Simulator::new(robot, &Gait::tripod(), settings).unwrap();
    if following {
        simulator = simulator.following_heading();
    }
    match simulator.simulate(&morphology) {
        Outcome::Walked(trajectory) => trajectory,
        Outcome::Diverged { at_s } => panic!("diverged at {at_s} s"),
    }
}

/// How far the robot turns in each cycle of the gait but the first two, degrees.
fn turns_deg(walk: &Trajectory) -> Vec<f64> {
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

fn last_position_m(walk: &Trajectory) -> [f64; 3] {
    *walk.position_m.as_ref().unwrap().last().unwrap()
}

fn distance_m(a: [f64; 3], b: [f64; 3]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b).powi(2));
    squares.sum::<f64>().sqrt()
}

#[test]
fn a_robot_turns_by_the_same_in_every_cycle() {
    for lost in ["3", "4", "5"] {
        let following = turns_deg(&walk(lost, SimulationSettings::default(), true));
        let staying = turns_deg(&walk(lost, SimulationSettings::default(), false));
        assert!(spread(&following) < 0.01, "{lost}: {following:?}");
        assert!(spread(&staying) > 0.03, "{lost}: {staying:?}");
        // Either walks the same way round, about as fast.
        assert!((following[0] / staying[0] - 1.0).abs() < 0.15);
    }
}

#[test]
fn the_way_is_the_same_and_so_is_a_pull() {
    let pulled = SimulationSettings {
        faults: vec![Fault::ExternalForce {
            force_n: [0.0, 3.0, 0.0],
        }],
        ..SimulationSettings::default()
    };
    let [free, free_following] =
        [false, true].map(|following| walk("4", SimulationSettings::default(), following));
    let [pulled, pulled_following] =
        [false, true].map(|following| walk("4", pulled.clone(), following));
    let (from, to) = (last_position_m(&free), last_position_m(&pulled));
    let moved_m = distance_m(from, to);
    assert!(distance_m(from, [0.0; 3]) > 0.2, "{from:?}");
    assert!(moved_m > 0.03, "{from:?} {to:?}");
    let (from_following, to_following) = (
        last_position_m(&free_following),
        last_position_m(&pulled_following),
    );
    assert!(
        distance_m(from, from_following) < 0.05,
        "{from_following:?}"
    );
    let change = |a: [f64; 3], b: [f64; 3]| [b[0] - a[0], b[1] - a[1], 0.0];
    let off_m = distance_m(change(from, to), change(from_following, to_following));
    assert!(off_m < 0.5 * moved_m, "{off_m} {moved_m}");
}

#[test]
fn gravity_stays_where_it_is_on_a_slope() {
    let slope = SimulationSettings {
        terrain: Terrain {
            slope_rad: 0.05,
            uphill_rad: 1.0,
            roughness: None,
        },
        ..SimulationSettings::default()
    };
    let [staying, following] = [false, true].map(|following| walk("5", slope.clone(), following));
    let (staying, following) = (staying.orientation, following.orientation);
    let pitch_deg = |angle_rad: &f64| angle_rad.to_degrees();
    let pitches_deg: Vec<f64> = staying.angles_rad().pitch.iter().map(pitch_deg).collect();
    let high = pitches_deg.iter().copied().fold(f64::MIN, f64::max);
    let low = pitches_deg.iter().copied().fold(f64::MAX, f64::min);
    // The robot turns, so that it climbs first and then walks across.
    assert!(high - low > 1.0, "{low} {high}");
    let both = pitches_deg.iter().zip(&following.angles_rad().pitch);
    let off = both.map(|(a, b)| (a - b.to_degrees()).abs());
    let largest_deg = off.fold(0.0, f64::max);
    assert!(largest_deg < 0.3, "{largest_deg}");
}
