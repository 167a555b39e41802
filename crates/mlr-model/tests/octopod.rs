//! The octopod of `data/robot/octopod.toml`, eight legs of three links, with its gait.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use mlr_model::{
    Gait, Morphology, Outcome, Record, Robot, SimulationSettings, Simulator, Trajectory,
};

const ROBOT: &str = include_str!("../../../data/robot/octopod.toml");
const GAIT: &str = include_str!("../../../data/gait/octopod.toml");

fn octopod() -> Robot {
    Robot::from_toml(ROBOT).unwrap()
}

/// Two seconds of standing, then five of walking.
fn walk(legs_lost: &str, gait: &Gait) -> Trajectory {
    let robot = octopod();
    let morphology = Morphology::parse_legs_lost(legs_lost, &robot.layout()).unwrap();
    let settings = SimulationSettings {
        stand_s: 2.0,
        record: Record {
            position: true,
            ..Default::default()
        },
        ..Default::default()
    };
    let simulator = Simulator::new(robot, gait, settings).unwrap();
    match simulator.simulate(&morphology) {
        Outcome::Walked(trajectory) => trajectory,
        Outcome::Diverged { at_s } => panic!("diverged at {at_s} s"),
    }
}

/// The largest tilt of the body while it stands and while it walks, degrees.
fn largest_tilt_deg(trajectory: &Trajectory) -> [f64; 2] {
    let angles = trajectory.orientation.angles_rad();
    let mut largest_rad = [0.0_f64; 2];
    let samples = trajectory.orientation.times_s().iter();
    for ((&time_s, roll), pitch) in samples.zip(&angles.roll).zip(&angles.pitch) {
        let largest_rad = &mut largest_rad[usize::from(time_s > 0.0)];
        *largest_rad = largest_rad.max(roll.abs()).max(pitch.abs());
    }
    largest_rad.map(f64::to_degrees)
}

#[test]
fn has_65536_morphologies() {
    let layout = octopod().layout();
    assert_eq!(layout.total_links(), 24);
    assert_eq!(layout.count(), Some(65_536));
    assert_eq!(layout.enumerate().count(), 65_536);
    // Control: the JetHexa's are those of two legs less.
    assert_eq!(Robot::jethexa().layout().count(), Some(65_536 / 16));
}

#[test]
fn its_body_has_the_inertia_of_the_box_that_it_is() {
    let robot = octopod();
    let body = robot.body();
    let of_box = |a: f64, b: f64| body.mass_kg / 12.0 * (a * a + b * b);
    let size = &body.size_m;
    let expected = [
        of_box(size.y, size.z),
        of_box(size.x, size.z),
        of_box(size.x, size.y),
    ];
    for (axis, expected) in expected.into_iter().enumerate() {
        let stated = body.inertia_kg_m2[axis];
        assert!(
            (stated / expected - 1.0).abs() < 1e-3,
            "{stated} {expected}"
        );
    }
}

#[test]
fn can_follow_its_own_gait_and_no_hexapods() {
    let prepare = |gait: &Gait| Simulator::new(octopod(), gait, SimulationSettings::default());
    assert!(prepare(&Gait::from_toml(GAIT).unwrap()).is_ok());
    assert!(prepare(&Gait::tripod()).is_err());
}

#[test]
fn stands_and_walks_level_while_it_is_healthy() {
    let gait = Gait::from_toml(GAIT).unwrap();
    let healthy = walk("", &gait);
    let [standing_deg, walking_deg] = largest_tilt_deg(&healthy);
    assert!(standing_deg < 0.1, "stands tilted by {standing_deg}°");
    assert!(walking_deg < 0.5, "walks tilted by {walking_deg}°");
    let [x_m, y_m, z_m] = *healthy.position_m.as_ref().unwrap().last().unwrap();
    assert!((0.45..0.60).contains(&x_m), "walked {x_m} m");
    assert!(y_m.abs() < 0.02, "strayed {y_m} m");
    let height_m = gait.feet().unwrap().body_height_m;
    assert!((z_m - height_m).abs() < 0.03, "body at {z_m} m");

    // Control: without any one of its legs it is not level.
    for leg in 1..=8 {
        let [_, walking_deg] = largest_tilt_deg(&walk(&leg.to_string(), &gait));
        assert!(walking_deg > 1.0, "leg {leg} lost: {walking_deg}°");
    }
}

#[test]
fn tips_over_with_legs_of_one_side_in_the_air_together() {
    // Control of the gait: the same feet in other groups do not carry the body.
    let mut pacing = Gait::from_toml(GAIT).unwrap();
    pacing.feet_mut().unwrap().phase_offsets = [0.0, 0.5].repeat(4);
    let [_, walking_deg] = largest_tilt_deg(&walk("", &pacing));
    assert!(walking_deg > 5.0, "{walking_deg}°");
}
