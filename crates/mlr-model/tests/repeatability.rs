//! Same inputs, same bits.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use mlr_model::{Gait, Morphology, Outcome, Robot, SimulationSettings, Simulator};
use rayon::prelude::*;

fn bits(simulator: &Simulator, morphology: &Morphology) -> Vec<u64> {
    match simulator.simulate(morphology) {
        Outcome::Walked(trajectory) => {
            let angles = trajectory.orientation.angles_rad();
            [&angles.roll, &angles.pitch, &angles.yaw]
                .into_iter()
                .flatten()
                .map(|angle| angle.to_bits())
                .collect()
        }
        Outcome::Diverged { at_s } => panic!("diverged at {at_s} s"),
    }
}

#[test]
fn identical_bits_for_1_2_and_8_threads() {
    let settings = SimulationSettings {
        duration_s: 1.5,
        ..Default::default()
    };
    let simulator = Simulator::new(Robot::jethexa(), &Gait::tripod(), settings).unwrap();
    let morphologies: Vec<_> = simulator
        .robot()
        .layout()
        .enumerate()
        .step_by(171)
        .collect();
    let run = |threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap()
            .install(|| {
                morphologies
                    .par_iter()
                    .map(|morphology| bits(&simulator, morphology))
                    .collect::<Vec<_>>()
            })
    };
    let alone = run(1);
    assert_eq!(alone, run(2));
    assert_eq!(alone, run(8));
    assert_ne!(alone[0], alone[1], "different robots move differently");
}
