//! Convergence study behind the default time step and substeps.
//!
//! Walks a few morphologies, healthy to badly damaged, at every combination of
//! time step and substeps and compares roll, pitch and yaw with a reference of
//! very fine steps. Prints a Markdown table: mean absolute error in degrees and
//! time per simulation on one core.
//!
//! ```text
//! cargo run --release -p mlr-model --example convergence
//! ```
#![allow(clippy::print_stdout, reason = "the table is what this program is for")]

use std::time::Instant;

use mlr_filter::{Axes, OrientationSeries};
use mlr_model::{
    Gait, LostLinks, ModelError, Morphology, Outcome, Robot, SimulationSettings, Simulator,
};

const MORPHOLOGIES: [&str; 8] = [
    "111 111 111 111 111 111",
    "111 111 000 111 111 111",
    "111 111 111 111 000 111",
    "111 111 000 000 111 111",
    "000 111 111 000 111 111",
    "111 110 110 111 111 111",
    "111 111 111 100 100 111",
    "000 111 000 111 111 000",
];
const REFERENCE: (f64, usize) = (0.000_25, 1);
const TIME_STEPS_S: [f64; 6] = [0.001, 0.002, 0.004, 0.005, 0.008, 0.010];
const SUBSTEPS: [usize; 3] = [1, 2, 4];
/// The common time vector: a multiple of every time step.
const SAMPLE_S: f64 = 0.040;

fn main() -> Result<(), ModelError> {
    let layout = Robot::jethexa().layout();
    let morphologies = MORPHOLOGIES
        .iter()
        .map(|text| Morphology::parse(text, &layout))
        .collect::<Result<Vec<_>, _>>()?;
    let (references, _) = walk_all(&morphologies, REFERENCE.0, REFERENCE.1)?;

    println!(
        "| step [ms] | substeps | roll [°] | pitch [°] | yaw [°] | worst yaw [°] | time [ms] |"
    );
    println!("|--:|--:|--:|--:|--:|--:|--:|");
    for time_step_s in TIME_STEPS_S {
        for substeps in SUBSTEPS {
            let (walks, seconds) = walk_all(&morphologies, time_step_s, substeps)?;
            let errors: Vec<Axes<f64>> = walks
                .iter()
                .zip(&references)
                .map(|(walk, reference)| mean_error_deg(walk, reference))
                .collect();
            let mean = |axis: fn(&Axes<f64>) -> f64| {
                errors.iter().map(axis).sum::<f64>() / errors.len() as f64
            };
            println!(
                "| {:.0} | {substeps} | {:.3} | {:.3} | {:.2} | {:.2} | {:.0} |",
                time_step_s * 1e3,
                mean(|e| e.roll),
                mean(|e| e.pitch),
                mean(|e| e.yaw),
                errors.iter().map(|e| e.yaw).fold(0.0, f64::max),
                seconds * 1e3 / morphologies.len() as f64,
            );
        }
    }
    Ok(())
}

fn walk_all(
    morphologies: &[Morphology],
    time_step_s: f64,
    substeps: usize,
) -> Result<(Vec<OrientationSeries>, f64), ModelError> {
    let settings = SimulationSettings {
        time_step_s,
        substeps,
        lost_links: LostLinks::Locked,
        ..Default::default()
    };
    let simulator = Simulator::new(Robot::jethexa(), &Gait::tripod(), settings)?;
    let started = Instant::now();
    let walks = morphologies
        .iter()
        .map(|morphology| match simulator.simulate(morphology) {
            Outcome::Walked(trajectory) => trajectory.orientation,
            Outcome::Diverged { at_s } => panic!("{morphology} diverged at {at_s} s"),
        })
        .collect();
    Ok((walks, started.elapsed().as_secs_f64()))
}

fn mean_error_deg(walk: &OrientationSeries, reference: &OrientationSeries) -> Axes<f64> {
    let error = |axis: fn(&Axes<Vec<f64>>) -> &Vec<f64>| {
        let sampled = |series: &OrientationSeries| -> Vec<f64> {
            let step_s = series.times_s()[1] - series.times_s()[0];
            let stride = (SAMPLE_S / step_s).round() as usize;
            axis(series.angles_rad())
                .iter()
                .step_by(stride)
                .copied()
                .collect()
        };
        let (ours, theirs) = (sampled(walk), sampled(reference));
        let total: f64 = ours.iter().zip(&theirs).map(|(a, b)| (a - b).abs()).sum();
        (total / ours.len() as f64).to_degrees()
    };
    Axes {
        roll: error(|angles| &angles.roll),
        pitch: error(|angles| &angles.pitch),
        yaw: error(|angles| &angles.yaw),
    }
}
