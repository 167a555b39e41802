//! How long an average candidate takes to simulate on one core: prints the mean over
//! morphologies given on the command line as remaining links per leg, as in
//! `330333`. `tools/bench/mujoco_speed.py` runs it side by side with MuJoCo.
#![allow(
    clippy::print_stdout,
    reason = "the figure is what this program is for"
)]

use std::time::Instant;

use mlr_model::{Gait, ModelError, Morphology, Robot, SimulationSettings, Simulator};

fn main() -> Result<(), ModelError> {
    let robot = Robot::jethexa();
    let layout = robot.layout();
    let candidates: Vec<Morphology> = std::env::args()
        .skip(1)
        .map(|text| {
            let healthy = Morphology::healthy(&layout);
            text.chars()
                .filter_map(|digit| digit.to_digit(10))
                .enumerate()
                .fold(healthy, |morphology, (leg, remaining)| {
                    morphology.with_remaining(leg, remaining as usize)
                })
        })
        .collect();
    let simulator = Simulator::new(robot, &Gait::tripod(), SimulationSettings::default())?;
    let started = Instant::now();
    for candidate in &candidates {
        std::hint::black_box(simulator.simulate(candidate));
    }
    let mean_ms = 1e3 * started.elapsed().as_secs_f64() / candidates.len().max(1) as f64;
    println!("{mean_ms:.3}");
    Ok(())
}
