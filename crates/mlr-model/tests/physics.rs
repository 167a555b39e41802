//! Properties that any walk must have, each with a control that lacks it.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use mlr_model::{
    Drive, Gait, GroundContact, LostLinks, Morphology, Outcome, Record, Robot, Roughness, Servo,
    SimulationSettings, Simulator, Terrain, Trajectory,
};

fn walk_with(robot: Robot, lost: &str, settings: SimulationSettings) -> Trajectory {
    let morphology = Morphology::parse_legs_lost(lost, &robot.layout()).unwrap();
    let simulator = Simulator::new(robot, &Gait::tripod(), settings).unwrap();
    match simulator.simulate(&morphology) {
        Outcome::Walked(trajectory) => trajectory,
        Outcome::Diverged { at_s } => panic!("diverged at {at_s} s"),
    }
}

fn walk(lost: &str) -> Trajectory {
    let settings = SimulationSettings {
        record: Record {
            position: true,
            contacts: true,
            torques: true,
            ..Default::default()
        },
        ..Default::default()
    };
    walk_with(Robot::jethexa(), lost, settings)
}

/// Largest absolute angle, in degrees.
fn largest_deg(angles_rad: &[f64]) -> f64 {
    angles_rad
        .iter()
        .fold(0.0_f64, |m, a| m.max(a.abs()))
        .to_degrees()
}

fn last_deg(angles_rad: &[f64]) -> f64 {
    angles_rad.last().unwrap().to_degrees()
}

#[test]
fn a_healthy_robot_walks_forward_without_rocking() {
    let healthy = walk("");
    let [x_m, y_m, _] = *healthy.position_m.as_ref().unwrap().last().unwrap();
    // Five steps of 120 mm per cycle, less the ramp of the first.
    assert!((0.45..0.60).contains(&x_m), "walked {x_m} m");
    assert!(y_m.abs() < 0.02, "strayed {y_m} m");
    let angles = healthy.orientation.angles_rad();
    assert!(largest_deg(&angles.roll) < 1.0);
    assert!(largest_deg(&angles.pitch) < 1.0);
    assert!(largest_deg(&angles.yaw) < 1.0);

    let damaged = walk("3");
    assert!(largest_deg(&damaged.orientation.angles_rad().roll) > 5.0);
}

#[test]
fn the_ground_carries_the_robot() {
    let walked = walk("");
    let forces = walked.contact_force_n.as_ref().unwrap();
    let mean_n = forces.iter().map(|f| f.iter().sum::<f64>()).sum::<f64>() / forces.len() as f64;
    let mass_kg = 1.369 + 6.0 * (0.02556 + 0.08807 + 0.08993);
    assert!((mean_n / (mass_kg * 9.81) - 1.0).abs() < 0.05, "{mean_n} N");
}

#[test]
fn a_lost_leg_bears_nothing_and_locked_links_keep_their_weight() {
    let mean_total_n = |lost_links| {
        let settings = SimulationSettings {
            lost_links,
            record: Record {
                contacts: true,
                ..Default::default()
            },
            ..Default::default()
        };
        let trajectory = walk_with(Robot::jethexa(), "3,4", settings);
        let forces = trajectory.contact_force_n.unwrap();
        assert!(forces.iter().all(|f| f[3] == 0.0 && f[4] == 0.0));
        forces.iter().map(|f| f.iter().sum::<f64>()).sum::<f64>() / forces.len() as f64
    };
    let difference_n = mean_total_n(LostLinks::Locked) - mean_total_n(LostLinks::Absent);
    let two_legs_n = 2.0 * (0.02556 + 0.08807 + 0.08993) * 9.81;
    assert!(
        (difference_n / two_legs_n - 1.0).abs() < 0.15,
        "{difference_n} N"
    );
}

#[test]
fn torques_stay_within_the_servo_and_belong_to_present_joints() {
    let torques = walk("1,4").torque_nm.unwrap();
    let limit_nm = Robot::jethexa().servo().torque_limit_nm;
    assert!(torques.iter().all(|t| t.len() == 12));
    assert!(torques.iter().flatten().all(|t| t.abs() <= limit_nm));
    assert!(torques.iter().flatten().any(|t| t.abs() > 0.2));
}

#[test]
fn mirrored_damage_gives_mirrored_roll_and_yaw() {
    // Swapping left and right also swaps the tripods: the mirror image of the
    // gait is the gait half a period later.
    let mut mirrored_gait = Gait::tripod();
    for pair in [(0, 1), (2, 3), (4, 5)] {
        let feet = mirrored_gait.feet_mut().unwrap();
        feet.phase_offsets.swap(pair.0, pair.1);
    }
    let simulate = |lost: &str, gait: &Gait| {
        let robot = Robot::jethexa();
        let morphology = Morphology::parse_legs_lost(lost, &robot.layout()).unwrap();
        let simulator = Simulator::new(robot, gait, SimulationSettings::default()).unwrap();
        match simulator.simulate(&morphology) {
            Outcome::Walked(trajectory) => trajectory.orientation,
            Outcome::Diverged { at_s } => panic!("diverged at {at_s} s"),
        }
    };
    for (lost, mirror_image) in [("3", "4"), ("1,4", "2,3"), ("5", "6")] {
        let walk = simulate(lost, &Gait::tripod());
        let mirrored = simulate(mirror_image, &mirrored_gait);
        let (ours, theirs) = (walk.angles_rad(), mirrored.angles_rad());
        let apart_deg = |ours: &[f64], theirs: &[f64], sign: f64| {
            let total: f64 = ours
                .iter()
                .zip(theirs)
                .map(|(a, b)| (a - sign * b).abs())
                .sum();
            (total / ours.len() as f64).to_degrees()
        };
        // Single precision and the order of contacts leave a small difference.
        let (roll, pitch, yaw) = (
            apart_deg(&ours.roll, &theirs.roll, -1.0),
            apart_deg(&ours.pitch, &theirs.pitch, 1.0),
            apart_deg(&ours.yaw, &theirs.yaw, -1.0),
        );
        assert!(roll < 0.1 && pitch < 0.1, "{lost}: {roll}° {pitch}°");
        assert!(
            yaw < 0.02 * last_deg(&ours.yaw).abs().max(20.0),
            "{lost}: {yaw}°"
        );
        assert!(
            apart_deg(&ours.roll, &theirs.roll, 1.0) > 1.0,
            "{lost}: control"
        );
    }
}

/// A robot whose servos do nothing.
fn limp() -> Robot {
    let servo = Servo {
        stiffness_nm_per_rad: 1e-9,
        damping_nm_s_per_rad: 0.0,
        ..*Robot::jethexa().servo()
    };
    Robot::jethexa().with_servo(servo).unwrap()
}

#[test]
fn dry_friction_of_its_gears_carries_a_robot_without_current() {
    let height_m = |coulomb_nm: f64| {
        let servo = *limp().servo();
        let drive = Drive {
            coulomb_nm,
            ..servo.drive
        };
        let robot = limp().with_servo(Servo { drive, ..servo }).unwrap();
        let settings = SimulationSettings {
            duration_s: 1.0,
            record: Record {
                position: true,
                ..Default::default()
            },
            ..Default::default()
        };
        let walked = walk_with(robot, "", settings);
        walked.position_m.unwrap().last().unwrap()[2]
    };
    // Three legs would carry 8.5 N each, at most 12 cm beside a joint: 1 N m.
    let (held, sunk) = (height_m(2.0), height_m(0.0));
    assert!(held > 0.07, "{held} m");
    assert!(sunk < 0.03, "{sunk} m: control");
}

/// The integrator's energy error is of first order in the step; this one makes
/// it small beside what the tests look for.
const DROP_STEP_S: f64 = 0.000_5;

fn drop_settings(clearance_m: f64) -> SimulationSettings {
    SimulationSettings {
        settle_s: 0.0,
        duration_s: 1.5,
        start_clearance_m: clearance_m,
        time_step_s: DROP_STEP_S,
        record: Record {
            energy: true,
            position: true,
            ..Default::default()
        },
        ..Default::default()
    }
}

#[test]
fn energy_never_grows_in_a_passive_drop() {
    let falling = walk_with(limp(), "", drop_settings(0.05));
    let energy_j = falling.energy_j.unwrap();
    let (first, last) = (energy_j[0], *energy_j.last().unwrap());
    let mut lowest_j = f64::INFINITY;
    for energy in &energy_j {
        lowest_j = lowest_j.min(*energy);
        // One per cent of what there was at first, for the integrator.
        assert!(
            *energy <= lowest_j + 0.01 * first,
            "{energy} after {lowest_j} J"
        );
    }
    assert!(last < 0.6 * first, "the legs give way: {first} to {last} J");

    // Control: servos that hold keep the body up.
    let held = walk_with(Robot::jethexa(), "", drop_settings(0.05));
    assert!(*held.energy_j.unwrap().last().unwrap() > 0.6 * first);
}

#[test]
fn energy_is_conserved_until_the_ground_is_hit() {
    let falling = walk_with(limp(), "2", drop_settings(2.0));
    let energy_j = falling.energy_j.unwrap();
    let height_m: Vec<f64> = falling.position_m.unwrap().iter().map(|p| p[2]).collect();
    let airborne_s = 0.5;
    let airborne_steps = (airborne_s / DROP_STEP_S) as usize;
    for energy in &energy_j[..airborne_steps] {
        assert!((energy / energy_j[0] - 1.0).abs() < 0.002, "{energy} J");
    }
    let fallen_m = height_m[0] - height_m[airborne_steps];
    assert!(
        (fallen_m - 0.5 * 9.81 * airborne_s * airborne_s).abs() < 0.003,
        "{fallen_m} m"
    );
    assert!(
        *energy_j.last().unwrap() < 0.5 * energy_j[0],
        "it does land"
    );
}

#[test]
fn on_a_slope_the_robot_stands_parallel_to_it() {
    let on = |uphill_deg: f64| {
        let settings = SimulationSettings {
            stand_s: 0.5,
            duration_s: 0.01,
            terrain: Terrain {
                slope_rad: 7.0_f64.to_radians(),
                uphill_rad: uphill_deg.to_radians(),
                roughness: None,
            },
            ..Default::default()
        };
        let standing = walk_with(Robot::jethexa(), "", settings).orientation;
        let angles = standing.angles_rad();
        (angles.roll[10].to_degrees(), angles.pitch[10].to_degrees())
    };
    let (roll_deg, pitch_deg) = on(0.0);
    assert!(
        roll_deg.abs() < 0.5 && (pitch_deg + 7.0).abs() < 0.5,
        "nose up is negative pitch"
    );
    let (roll_deg, pitch_deg) = on(90.0);
    assert!(
        (roll_deg - 7.0).abs() < 0.5 && pitch_deg.abs() < 0.5,
        "left side up is positive roll"
    );
}

#[test]
fn rubble_shakes_a_healthy_robot() {
    let settings = SimulationSettings {
        duration_s: 3.0,
        terrain: Terrain {
            roughness: Some(Roughness {
                height_m: 0.02,
                spacing_m: 0.05,
                seed: 3,
            }),
            ..Default::default()
        },
        ..Default::default()
    };
    let shaken = walk_with(Robot::jethexa(), "", settings.clone()).orientation;
    assert!(largest_deg(&shaken.angles_rad().roll) > 1.0);
    let again = walk_with(Robot::jethexa(), "", settings).orientation;
    assert_eq!(shaken, again);
}

#[test]
fn less_friction_lets_a_weak_group_turn_the_robot_less() {
    let yaw_deg = |friction: f64| {
        let settings = SimulationSettings {
            contact: GroundContact {
                friction,
                ..Default::default()
            },
            ..Default::default()
        };
        let walked = walk_with(Robot::jethexa(), "5", settings);
        last_deg(&walked.orientation.angles_rad().yaw).abs()
    };
    assert!(yaw_deg(0.1) < 0.6 * yaw_deg(0.7));
}

#[test]
fn a_state_that_blows_up_is_an_outcome() {
    // Links of next to no inertia: single precision cannot solve for their speed.
    let hollow: String = Robot::JETHEXA_TOML
        .lines()
        .map(|line| match line {
            line if line.starts_with("inertia") && line.contains("e-5") => {
                "inertia_kg_m2 = [1e-20, 1e-20, 1e-20]\n".into()
            }
            line => format!("{line}\n"),
        })
        .collect();
    let robot = Robot::from_toml(&hollow).unwrap();
    let simulator = Simulator::new(robot, &Gait::tripod(), SimulationSettings::default()).unwrap();
    let layout = simulator.robot().layout();
    let outcome = simulator.simulate(&Morphology::healthy(&layout));
    assert!(matches!(outcome, Outcome::Diverged { .. }), "{outcome:?}");

    let body_only = Morphology::parse_legs_lost("1,2,3,4,5,6", &layout).unwrap();
    assert!(matches!(simulator.simulate(&body_only), Outcome::Walked(_)));
}
