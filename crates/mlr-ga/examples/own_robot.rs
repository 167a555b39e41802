//! The damaged legs of any robot whose description and gait are in TOML files, like those in
//! `data/robot` and `data/gait`.
//!
//! ```text
//! cargo run --release -p mlr-ga --example own_robot -- \
//!     data/logs/stand-in/leg3-lost.csv.gz data/robot/jethexa.toml data/gait/tripod.toml
//! ```
#![allow(
    clippy::print_stdout,
    reason = "the answer is what this program is for"
)]

use std::fs;

use anyhow::{Context, bail};
use mlr_ga::{Columns, Gait, IdentifySettings, Model, Robot, identify, read_log};

fn main() -> anyhow::Result<()> {
    let files: Vec<String> = std::env::args().skip(1).collect();
    let [log, robot, gait] = files.as_slice() else {
        bail!("expected a log, a robot and a gait");
    };
    let recording = read_log(log, &Columns::default())?;
    let read = |path: &String| fs::read_to_string(path).context(path.clone());
    let robot = Robot::from_toml(&read(robot)?)?;
    let gait = Gait::from_toml(&read(gait)?)?;
    let settings = IdentifySettings::default();
    let model = Model::new(&robot, &gait);
    let answer = identify(&recording, model, &settings, &())?;
    println!("{}: {}", robot.name(), answer.description);
    for (leg, probability) in robot.legs().iter().zip(&answer.leg_damage_probability) {
        println!("{} is damaged: {:.1} %", leg.name, 100.0 * probability);
    }
    Ok(())
}
