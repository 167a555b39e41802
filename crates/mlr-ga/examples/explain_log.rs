//! What else is wrong with a JetHexa besides lost links: a payload, a slope, a weak leg, a
//! sensor that sits askew.
//!
//! ```text
//! cargo run --release -p mlr-ga --example explain_log -- data/logs/stand-in/undeclared-c.csv.gz
//! ```
#![allow(
    clippy::print_stdout,
    reason = "the answer is what this program is for"
)]

use anyhow::Context;
use mlr_ga::{
    Columns, EvidenceSettings, ExplainSettings, IdentifySettings, Model, explain, read_log,
};

fn main() -> anyhow::Result<()> {
    let log = std::env::args().nth(1).context("expected a log")?;
    let recording = read_log(log, &Columns::default())?;
    let settings = ExplainSettings {
        identify: &IdentifySettings::default(),
        explanation: &EvidenceSettings::default(),
    };
    let found = explain(&recording, Model::jethexa(), settings, &())?.explanation;
    println!("{}: {}", found.morphology, found.morphology.describe());
    for effect in &found.effects {
        println!("{}", effect.kind);
        for (name, value) in &effect.parameters {
            println!("    {name} = {value}");
        }
    }
    let (before, after) = (found.error_before, found.error_after);
    println!(
        "RMS error on the unseen third: {:.2}° as described, {:.2}° with the effects",
        before.validation_deg, after.validation_deg
    );
    Ok(())
}
