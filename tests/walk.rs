//! Simulated walks against MuJoCo (`tools/golden/mujoco_walk.py`): another engine, another
//! implementation of robot, gait and servo, the same facts.
//!
//! What moves is compared relative to how far it moves, so that a robot that stands still has
//! an error of 1 everywhere. The engines' contact laws differ: bodies slip differently, which
//! makes up most of what is allowed. How far a robot slips sideways is not compared.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeMap;

use mlr_golden_tests::columns;
use mlr_model::{Gait, Morphology, Outcome, Record, Robot, SimulationSettings, Simulator};

const TIME_STEP_S: f64 = 0.001;
const GOLDEN_STEP_S: f64 = 0.02;

/// The morphologies whose walks MuJoCo has simulated.
const CASES: [(&str, &str); 5] = [
    ("healthy", "111 111 111 111 111 111"),
    ("leg3-lost", "111 111 000 111 111 111"),
    ("legs3-4-lost", "111 111 000 000 111 111"),
    ("legs4-5-lost", "111 111 111 000 000 111"),
    ("legs2-3-tibia-lost", "111 110 110 111 111 111"),
];

/// A signal of the body, and when and how closely it must agree.
struct Compared {
    name: &'static str,
    /// Signals that move less (root mean square) are not compared.
    moves_by: f64,
    /// Largest error (root mean square), as a share of the golden signal's motion.
    share: f64,
}

/// In the order of [`Motion::signals`]; angles in degrees, lengths in millimetres. In
/// brackets the largest share of the five cases.
const COMPARED: [Compared; 5] = [
    // Healthy robots included (0.36); of damaged ones at most 0.31.
    Compared {
        name: "roll",
        moves_by: 0.1,
        share: 0.40,
    },
    // Legs 4 and 5 lost (0.57).
    Compared {
        name: "pitch",
        moves_by: 0.08,
        share: 0.62,
    },
    // Legs 3 and 4 lost (0.16).
    Compared {
        name: "yaw",
        moves_by: 1.0,
        share: 0.20,
    },
    // Legs 4 and 5 lost (0.22); healthy 0.01.
    Compared {
        name: "forward",
        moves_by: 50.0,
        share: 0.25,
    },
    // Legs 2 and 3 without tibia (0.08).
    Compared {
        name: "height",
        moves_by: 1.0,
        share: 0.10,
    },
];

/// The yaw turned at the end, as a share of the golden one (the largest is 0.17).
const TURNED_SHARE: f64 = 0.20;
/// Robots that turn less are not asked how far.
const TURNS_BY_DEG: f64 = 3.0;

/// How a body moves.
#[derive(Debug, Clone)]
struct Motion {
    /// Roll, pitch, yaw, the way forward, and height: what is free is removed, which is the
    /// start of yaw and of the way, and the mean of roll, pitch and height.
    signals: [Vec<f64>; 5],
}

impl Motion {
    fn new(angles_rad: [Vec<f64>; 3], [x_m, y_m, z_m]: [Vec<f64>; 3]) -> Self {
        let forward_m = way_forward_m(&angles_rad[2], &x_m, &y_m);
        let [roll, pitch, yaw] = angles_rad.map(|angle| scaled(angle, 1_f64.to_degrees()));
        let [forward, height] = [forward_m, z_m].map(|length| scaled(length, 1000.0));
        Self {
            signals: [
                without_mean(roll),
                without_mean(pitch),
                from_start(yaw),
                forward,
                without_mean(height),
            ],
        }
    }

    fn golden(case: &str) -> Self {
        let names = ["roll_rad", "pitch_rad", "yaw_rad", "x_m", "y_m", "z_m"];
        let path = format!("golden/mujoco/{case}.csv");
        let [roll, pitch, yaw, x, y, z] = columns(&path, names);
        Self::new([roll, pitch, yaw], [x, y, z])
    }

    fn simulated(morphology: &str) -> Self {
        let robot = Robot::jethexa();
        let morphology = Morphology::parse(morphology, &robot.layout()).unwrap();
        let settings = SimulationSettings {
            time_step_s: TIME_STEP_S,
            record: Record {
                position: true,
                ..Record::default()
            },
            ..SimulationSettings::default()
        };
        let simulator = Simulator::new(robot, &Gait::tripod(), settings).unwrap();
        let Outcome::Walked(trajectory) = simulator.simulate(&morphology) else {
            panic!("{morphology} diverged");
        };
        let every = (GOLDEN_STEP_S / TIME_STEP_S).round() as usize;
        let angles = trajectory.orientation.angles_rad();
        let positions_m = trajectory.position_m.unwrap();
        Self::new(
            [&angles.roll, &angles.pitch, &angles.yaw]
                .map(|angle| angle.iter().step_by(every).copied().collect()),
            [0, 1, 2].map(|axis| positions_m.iter().step_by(every).map(|p| p[axis]).collect()),
        )
    }

    /// A robot that does nothing for as long as this one walks.
    fn standing_still(&self) -> Self {
        Self {
            signals: self.signals.clone().map(|signal| vec![0.0; signal.len()]),
        }
    }

    fn turned_deg(&self) -> f64 {
        *self.signals[2].last().unwrap()
    }

    /// What is compared, each with its error as a share of the `golden` motion and with the
    /// largest share that it may have.
    fn errors(&self, golden: &Self) -> BTreeMap<&'static str, (f64, f64)> {
        let pairs = self.signals.iter().zip(&golden.signals).zip(COMPARED);
        let mut errors: BTreeMap<_, _> = pairs
            .filter(|((_, theirs), compared)| rms(theirs) > compared.moves_by)
            .map(|((ours, theirs), compared)| {
                assert_eq!(ours.len(), theirs.len());
                let apart: Vec<f64> = ours.iter().zip(theirs).map(|(a, b)| a - b).collect();
                (compared.name, (rms(&apart) / rms(theirs), compared.share))
            })
            .collect();
        let turned_deg = golden.turned_deg();
        if turned_deg.abs() > TURNS_BY_DEG {
            let share = (self.turned_deg() / turned_deg - 1.0).abs();
            errors.insert("turned", (share, TURNED_SHARE));
        }
        errors
    }

    fn agrees_with(&self, golden: &Self) -> bool {
        let errors = self.errors(golden);
        errors.values().all(|(share, largest)| share <= largest)
    }
}

/// How far the body went the way it was heading.
fn way_forward_m(yaw_rad: &[f64], x_m: &[f64], y_m: &[f64]) -> Vec<f64> {
    let mut way_m = vec![0.0];
    for i in 1..yaw_rad.len() {
        let heading_rad = 0.5 * (yaw_rad[i - 1] + yaw_rad[i]);
        let step_m =
            (x_m[i] - x_m[i - 1]) * heading_rad.cos() + (y_m[i] - y_m[i - 1]) * heading_rad.sin();
        way_m.push(way_m[i - 1] + step_m);
    }
    way_m
}

fn scaled(signal: Vec<f64>, by: f64) -> Vec<f64> {
    signal.into_iter().map(|x| x * by).collect()
}

fn without_mean(signal: Vec<f64>) -> Vec<f64> {
    let mean = signal.iter().sum::<f64>() / signal.len() as f64;
    signal.into_iter().map(|x| x - mean).collect()
}

fn from_start(signal: Vec<f64>) -> Vec<f64> {
    let start = signal[0];
    signal.into_iter().map(|x| x - start).collect()
}

fn rms(signal: &[f64]) -> f64 {
    (signal.iter().map(|x| x * x).sum::<f64>() / signal.len() as f64).sqrt()
}

/// The walk of `case` agrees with the golden one in all of `compared`; a robot that stands
/// still agrees in none of them, and the robots of the other cases, like all of `others`, not
/// in every one.
fn assert_agrees(case: &str, compared: &[&str], others: &[&str]) {
    let golden = Motion::golden(case);
    let morphology = CASES.iter().find(|(name, _)| *name == case).unwrap().1;
    let errors = Motion::simulated(morphology).errors(&golden);
    let names: Vec<&str> = errors.keys().copied().collect();
    assert_eq!(names, compared, "{case}: what moves");
    for (name, (share, largest)) in errors {
        assert!(share <= largest, "{case}: {name} {share:.3} of its motion");
    }

    for (name, (share, largest)) in golden.standing_still().errors(&golden) {
        assert!(
            share > 1.5 * largest,
            "{case}: standing still, {name} {share}"
        );
    }
    let cases = CASES.iter().map(|(_, morphology)| morphology);
    for other in cases.chain(others).filter(|other| **other != morphology) {
        let walk = Motion::simulated(other);
        assert!(!walk.agrees_with(&golden), "{case}: {other} agrees");
    }
}

#[test]
fn healthy() {
    let others = ["111 111 111 111 111 110", "110 111 111 111 111 111"];
    assert_agrees("healthy", &["forward", "pitch", "roll"], &others);
}

#[test]
fn one_leg() {
    let compared = ["forward", "height", "roll", "turned", "yaw"];
    let others = ["111 111 111 000 111 111", "000 111 111 111 111 111"];
    assert_agrees("leg3-lost", &compared, &others);
}

#[test]
fn both_middle_legs() {
    let compared = ["height", "roll", "turned", "yaw"];
    let others = ["111 111 111 000 111 111"];
    assert_agrees("legs3-4-lost", &compared, &others);
}

#[test]
fn two_legs_of_one_tripod() {
    let compared = ["forward", "height", "pitch", "roll", "turned", "yaw"];
    let others = ["111 111 111 000 111 111", "000 111 111 000 111 111"];
    assert_agrees("legs4-5-lost", &compared, &others);
}

#[test]
fn two_last_links() {
    let compared = ["forward", "height", "pitch", "roll", "turned", "yaw"];
    let others = ["111 111 110 111 111 111", "111 110 111 111 111 111"];
    assert_agrees("legs2-3-tibia-lost", &compared, &others);
}
