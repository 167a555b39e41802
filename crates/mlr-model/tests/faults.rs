//! What faults do to a walk, with the healthy walk as control.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use mlr_model::{
    Fault, Gait, GroundContact, Morphology, Outcome, Record, Robot, RobotParameter,
    SimulationSettings, Simulator, Trajectory,
};

fn walk_with(faults: &[Fault]) -> Trajectory {
    let settings = SimulationSettings {
        duration_s: 3.0,
        stand_s: 0.5,
        faults: faults.to_vec(),
        record: Record {
            position: true,
            contacts: true,
            ..Record::default()
        },
        ..SimulationSettings::default()
    };
    let robot = Robot::jethexa();
    let healthy = Morphology::healthy(&robot.layout());
    let simulator = Simulator::new(robot, &Gait::tripod(), settings).unwrap();
    match simulator.simulate(&healthy) {
        Outcome::Walked(trajectory) => trajectory,
        Outcome::Diverged { at_s } => panic!("diverged at {at_s} s"),
    }
}

/// Largest difference of roll, pitch and yaw between two walks, in degrees.
fn largest_difference_deg(a: &Trajectory, b: &Trajectory) -> [f64; 3] {
    let (a, b) = (a.orientation.angles_rad(), b.orientation.angles_rad());
    [(&a.roll, &b.roll), (&a.pitch, &b.pitch), (&a.yaw, &b.yaw)].map(|(a, b)| {
        let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs().to_degrees());
        differences.fold(0.0, f64::max)
    })
}

fn swing_deg(angles_rad: &[f64]) -> f64 {
    let high = angles_rad.iter().copied().fold(f64::MIN, f64::max);
    let low = angles_rad.iter().copied().fold(f64::MAX, f64::min);
    (high - low).to_degrees()
}

#[test]
fn zeros_of_the_description_are_those_of_a_remounted_horn() {
    let walk_of = |robot: Robot, faults: Vec<Fault>| {
        let settings = SimulationSettings {
            duration_s: 2.0,
            faults,
            ..SimulationSettings::default()
        };
        let healthy = Morphology::healthy(&robot.layout());
        let simulator = Simulator::new(robot, &Gait::tripod(), settings).unwrap();
        match simulator.simulate(&healthy) {
            Outcome::Walked(trajectory) => trajectory,
            Outcome::Diverged { at_s } => panic!("diverged at {at_s} s"),
        }
    };
    let angle_rad = 0.05;
    let remounted = Fault::JointOffset {
        leg: 4,
        joint: 2,
        angle_rad,
    };
    let zero = RobotParameter::JointZero { leg: 3, joint: 1 };
    let own = Robot::jethexa().with_added(zero, angle_rad);
    let described = walk_of(own, Vec::new());
    let faulty = walk_of(Robot::jethexa(), vec![remounted]);
    assert_eq!(described.orientation, faulty.orientation);
    // The control: it shows.
    let plain = walk_of(Robot::jethexa(), Vec::new());
    let [roll_deg, ..] = largest_difference_deg(&described, &plain);
    assert!(roll_deg > 0.1, "{roll_deg}");
}

#[test]
fn faults_of_no_size_change_nothing() {
    let none = [
        Fault::WeakLeg { leg: 3, gain: 1.0 },
        Fault::JointOffset {
            leg: 2,
            joint: 1,
            angle_rad: 0.0,
        },
        Fault::ShortLink {
            leg: 6,
            link: 3,
            length_lost_m: 0.0,
        },
        Fault::ExternalForce { force_n: [0.0; 3] },
        Fault::FootFriction {
            leg: 1,
            mu: GroundContact::default().friction,
        },
    ];
    let difference = largest_difference_deg(&walk_with(&none), &walk_with(&[]));
    assert!(difference.iter().all(|d| *d < 0.05), "{difference:?}");
}

#[test]
fn mirrored_faults_mirror_the_walk() {
    // Leg 1 is front left, leg 2 front right; the tripods are each other's mirror image
    // half a period later, which leaves the lean.
    let lean_deg = |leg| {
        let walk = walk_with(&[Fault::ShortLink {
            leg,
            link: 3,
            length_lost_m: 0.03,
        }]);
        let angles = walk.orientation.angles_rad();
        let mean = |a: &[f64]| a.iter().sum::<f64>().to_degrees() / a.len() as f64;
        (mean(&angles.roll), mean(&angles.pitch))
    };
    let (left, right) = (lean_deg(1), lean_deg(2));
    assert!(left.0 < -0.3 && right.0 > 0.3, "{left:?} {right:?}");
    assert!((left.0 + right.0).abs() < 0.2, "{left:?} {right:?}");
    let pitches = (left.1, right.1);
    assert!(
        left.1 > 0.3 && (left.1 - right.1).abs() < 0.5,
        "the front sinks: {pitches:?}"
    );
}

#[test]
fn a_weak_leg_carries_less_and_lets_the_body_swing() {
    let (weak, healthy) = (
        walk_with(&[Fault::WeakLeg { leg: 3, gain: 0.15 }]),
        walk_with(&[]),
    );
    let load_n = |walk: &Trajectory| {
        let forces = walk.contact_force_n.as_ref().unwrap();
        forces.iter().map(|of_legs| of_legs[3]).sum::<f64>() / forces.len() as f64
    };
    let loads_n = (load_n(&weak), load_n(&healthy));
    assert!(loads_n.0 < 0.9 * loads_n.1, "{loads_n:?}");
    let swing = |walk: &Trajectory| swing_deg(&walk.orientation.angles_rad().roll);
    let swings_deg = (swing(&weak), swing(&healthy));
    assert!(swings_deg.0 > 2.0 * swings_deg.1, "{swings_deg:?}");
}

#[test]
fn a_stuck_joint_is_where_it_is_stuck_and_an_offset_joint_moves_on() {
    let stuck = walk_with(&[Fault::StuckJoint {
        leg: 3,
        joint: 2,
        angle_rad: 0.9,
    }]);
    // The femur points up: the foot hangs above the ground unless the body tips over.
    let standing_share = |walk: &Trajectory| {
        let forces = walk.contact_force_n.as_ref().unwrap();
        let standing = forces.iter().filter(|of_legs| of_legs[3] > 0.0).count();
        standing as f64 / forces.len() as f64
    };
    assert!(standing_share(&stuck) < 0.4, "{}", standing_share(&stuck));
    let offset = walk_with(&[Fault::JointOffset {
        leg: 3,
        joint: 2,
        angle_rad: -0.15,
    }]);
    assert!(standing_share(&offset) > 0.6, "it pushes deeper");
    assert!(largest_difference_deg(&offset, &walk_with(&[]))[0] > 1.0);
}

#[test]
fn a_foot_without_grip_turns_the_body() {
    let slippery = walk_with(&[Fault::FootFriction { leg: 3, mu: 0.02 }]);
    let difference = largest_difference_deg(&slippery, &walk_with(&[]));
    assert!(difference[2] > 0.3, "{difference:?}");
}

#[test]
fn a_pull_moves_the_robot_its_way() {
    let drift_m = |force_n| {
        let walk = walk_with(&[Fault::ExternalForce { force_n }]);
        let positions = walk.position_m.unwrap();
        positions.last().unwrap()[1] - positions[0][1]
    };
    let (left, none, right) = (
        drift_m([0.0, 4.0, 0.0]),
        drift_m([0.0; 3]),
        drift_m([0.0, -4.0, 0.0]),
    );
    assert!(left > none && none > right, "{left} {none} {right}");
}

#[test]
fn faults_that_the_robot_cannot_have_are_refused() {
    let cases = [
        (Fault::WeakLeg { leg: 0, gain: 0.5 }, "faults[0].leg"),
        (Fault::WeakLeg { leg: 7, gain: 0.5 }, "faults[0].leg"),
        (
            Fault::WeakLeg {
                leg: 1,
                gain: f64::NAN,
            },
            "faults[0].gain",
        ),
        (Fault::FootFriction { leg: 1, mu: -0.1 }, "faults[0].mu"),
        (
            Fault::StuckJoint {
                leg: 1,
                joint: 4,
                angle_rad: 0.0,
            },
            "faults[0].joint",
        ),
        (
            Fault::ShortLink {
                leg: 1,
                link: 2,
                length_lost_m: 0.2,
            },
            "faults[0].length_lost_m",
        ),
        (
            Fault::ExternalForce {
                force_n: [0.0, f64::INFINITY, 0.0],
            },
            "faults[0].force_n",
        ),
    ];
    for (fault, field) in cases {
        let settings = SimulationSettings {
            faults: vec![fault],
            ..SimulationSettings::default()
        };
        let error = Simulator::new(Robot::jethexa(), &Gait::tripod(), settings).unwrap_err();
        assert!(error.to_string().contains(field), "{error}");
    }
}
