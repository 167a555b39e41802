//! The damaged legs of a JetHexa from a log of its IMU.
//!
//! ```text
//! cargo run --release -p mlr-ga --example identify_log -- data/logs/stand-in/leg3-lost.csv.gz
//! ```
#![allow(
    clippy::print_stdout,
    reason = "the answer is what this program is for"
)]

use anyhow::Context;
use mlr_ga::{Columns, IdentifySettings, Model, identify, read_log};

fn main() -> anyhow::Result<()> {
    let log = std::env::args().nth(1).context("expected a log")?;
    let recording = read_log(log, &Columns::default())?;
    let settings = IdentifySettings::default();
    let answer = identify(&recording, Model::jethexa(), &settings, &())?;
    println!("{}: {}", answer.morphology, answer.description);
    for (leg, probability) in (1..).zip(&answer.leg_damage_probability) {
        println!("leg {leg} is damaged: {:.1} %", 100.0 * probability);
    }
    Ok(())
}
