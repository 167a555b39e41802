//! Walks morphologies for `tools/bench/speed.py`, which measures the processor time of
//! this program and compares the walks with finer ones.
//!
//! ```text
//! walk_speed STEP_S REPEATS MORPHOLOGY…
//! ```
//!
//! Every morphology, given by its existence numbers, walks REPEATS times with a time step
//! of STEP_S. Prints a line for each: roll, pitch and yaw in radians every 20 ms of the walk.
#![allow(
    clippy::print_stdout,
    reason = "the walks are what this program is for"
)]

use std::{error::Error, fmt::Write};

use mlr_filter::OrientationSeries;
use mlr_model::{Gait, Morphology, Outcome, Robot, SimulationSettings, Simulator};

/// A multiple of every time step that is compared.
const SAMPLE_S: f64 = 0.020;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let mut next = || {
        arguments
            .next()
            .ok_or("STEP_S REPEATS MORPHOLOGY… expected")
    };
    let time_step_s: f64 = next()?.parse()?;
    let repeats: usize = next()?.parse()?;

    let robot = Robot::jethexa();
    let layout = robot.layout();
    let settings = SimulationSettings {
        time_step_s,
        ..Default::default()
    };
    let simulator = Simulator::new(robot, &Gait::tripod(), settings)?;
    for text in arguments {
        let morphology = Morphology::parse(&text, &layout)?;
        for _ in 1..repeats {
            std::hint::black_box(simulator.simulate(&morphology));
        }
        match simulator.simulate(&morphology) {
            Outcome::Walked(trajectory) => println!("{}", line(&trajectory.orientation)),
            Outcome::Diverged { at_s } => return Err(format!("{text} diverged at {at_s} s").into()),
        }
    }
    Ok(())
}

fn line(orientation: &OrientationSeries) -> String {
    let times_s = orientation.times_s();
    let stride = (SAMPLE_S / (times_s[1] - times_s[0])).round() as usize;
    let angles = orientation.angles_rad();
    let axes = angles.roll.iter().zip(&angles.pitch).zip(&angles.yaw);
    let mut line = String::new();
    for ((roll, pitch), yaw) in axes.step_by(stride) {
        // Writing to a string cannot fail.
        let _ = write!(line, "{roll:.7} {pitch:.7} {yaw:.7} ");
    }
    line
}
