//! Simulated walks against recorded bits: the same on every platform, in every
//! build, with any number of threads.
//!
//! A change of the model or of the physics engine changes the bits. When that is
//! meant, record them anew:
//!
//! ```text
//! MLR_RECORD_GOLDEN=1 cargo test -p mlr-model --test bits
//! ```
//!
//! The walks of the engine as it was released are not recorded anew: `third_party/README.md` says what is
//! changed in ours. They are of robots on ground without friction, which the released engine solves otherwise.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::{collections::HashMap, fmt::Write, fs};

use mlr_model::{
    Gait, GroundContact, LostLinks, Morphology, Outcome, Robot, Roughness, SimulationSettings,
    Simulator, Terrain,
};
use rayon::prelude::*;

const GOLDEN: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../data/golden/bits/walks.txt"
);
const RELEASED_ENGINE: &str = include_str!("../../../data/golden/bits/released-engine.txt");
const MORPHOLOGIES: [&str; 4] = [
    "111 111 111 111 111 111",
    "111 111 000 111 111 111",
    "000 111 111 110 111 111",
    "000 100 110 111 000 111",
];

/// One line per case and half second: case, time, bits of roll, pitch and yaw.
fn walks(contact: GroundContact) -> String {
    let rubble = Terrain {
        slope_rad: 0.1,
        uphill_rad: 0.5,
        roughness: Some(Roughness {
            height_m: 0.006,
            spacing_m: 0.05,
            seed: 1,
        }),
    };
    let grounds = [("flat", Terrain::default()), ("rubble", rubble)];
    let cases: Vec<_> = grounds
        .iter()
        .flat_map(|ground| [LostLinks::Absent, LostLinks::Locked].map(|lost| (ground, lost)))
        .flat_map(|(ground, lost)| MORPHOLOGIES.map(|morphology| (ground, lost, morphology)))
        .collect();
    cases
        .into_par_iter()
        .map(|((ground, terrain), lost_links, morphology)| {
            let settings = SimulationSettings {
                lost_links,
                terrain: terrain.clone(),
                contact,
                ..Default::default()
            };
            walk(ground, settings, morphology)
        })
        .collect()
}

fn walk(ground: &str, settings: SimulationSettings, text: &str) -> String {
    let lost_links = settings.lost_links;
    let simulator = Simulator::new(Robot::jethexa(), &Gait::tripod(), settings).unwrap();
    let morphology = Morphology::parse(text, &simulator.robot().layout()).unwrap();
    let Outcome::Walked(trajectory) = simulator.simulate(&morphology) else {
        panic!("{text} diverged");
    };
    let angles = trajectory.orientation.angles_rad();
    let mut lines = String::new();
    let times_s = trajectory.orientation.times_s().iter().enumerate();
    for (index, time_s) in times_s.step_by(50) {
        writeln!(
            lines,
            "{ground} {lost_links:?} {} {time_s:.1} {:016x} {:016x} {:016x}",
            text.replace(' ', "-"),
            angles.roll[index].to_bits(),
            angles.pitch[index].to_bits(),
            angles.yaw[index].to_bits(),
        )
        .unwrap();
    }
    lines
}

#[test]
fn walks_have_the_recorded_bits() {
    let walked = walks(GroundContact::default());
    if std::env::var_os("MLR_RECORD_GOLDEN").is_some() {
        fs::write(GOLDEN, &walked).unwrap();
    }
    let recorded = fs::read_to_string(GOLDEN).unwrap();
    for (ours, golden) in walked.lines().zip(recorded.lines()) {
        assert_eq!(ours, golden);
    }
    assert_eq!(walked.lines().count(), recorded.lines().count());
    assert_eq!(recorded.lines().count(), 2 * 2 * 4 * 11);
}

/// The mass matrix that the released engine assembles and factorizes in full, ours along the legs: sums that
/// round otherwise, and walks that differ by as little.
#[test]
fn walks_without_friction_are_those_of_the_released_engine_but_for_rounding() {
    let rounding_rad = 1e-5;
    let slippery = GroundContact {
        friction: 0.0,
        ..Default::default()
    };
    let ours = largest_difference_rad(&walks(slippery));
    assert!(ours < rounding_rad, "{ours:e} rad");

    let firmer = GroundContact {
        natural_frequency_hz: 1.1 * slippery.natural_frequency_hz,
        ..slippery
    };
    let control = largest_difference_rad(&walks(firmer));
    assert!(control > 10.0 * rounding_rad, "{control:e} rad");
}

/// Between these walks and those of the released engine, which are of robots that neither slide down a slope
/// nor are about to tip.
fn largest_difference_rad(walked: &str) -> f64 {
    let named = |line: &str| -> (String, Vec<f64>) {
        let words: Vec<_> = line.split(' ').collect();
        let angle = |bits: &&str| f64::from_bits(u64::from_str_radix(bits, 16).unwrap());
        (words[..4].join(" "), words[4..].iter().map(angle).collect())
    };
    let ours: HashMap<_, _> = walked.lines().map(named).collect();
    let differences = RELEASED_ENGINE.lines().map(named).map(|(name, released)| {
        let both = ours[&name].iter().zip(&released);
        both.fold(0.0, |largest: f64, (a, b)| largest.max((a - b).abs()))
    });
    differences.fold(0.0, f64::max)
}
