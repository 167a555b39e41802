//! Compares the genetic algorithm and the exact search with the truth on a
//! folder of logs. Prints a Markdown table.
//!
//! For each log: one identification with the genetic algorithm, as a user would
//! run it; the exact search; and ten seeds of the genetic algorithm on what the
//! exact search has learnt, to see how often it reaches the optimum: with default
//! settings, and with one population and no refinement as in the paper. Only this
//! evaluation reads the folder's `truth.json`.
//!
//! ```text
//! cargo run --release -p mlr-ga --example evaluate -- data/logs/stand-in [NAME…]
//! ```
#![allow(clippy::print_stdout, reason = "the table is what this program is for")]

use std::{collections::BTreeMap, fs, path::Path, time::Instant};

use anyhow::Context;
use mlr_ga::{
    Evaluations, IdentifySettings, MeasuredWalk, Search, WalkObjective, exact,
    genetic::{self, GeneticSettings},
    identify,
};
use mlr_imu::{Columns, read_log};
use mlr_model::{Gait, LegLayout, Morphology, Robot};
use serde::Deserialize;

const SEEDS: u64 = 10;

#[derive(Deserialize)]
struct Truth {
    morphology: Vec<Vec<u8>>,
}

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().context("expected a folder of logs")?;
    let folder = Path::new(&folder);
    let only: Vec<String> = arguments.collect();
    let truths: BTreeMap<String, Truth> =
        serde_json::from_str(&fs::read_to_string(folder.join("truth.json"))?)?;
    let layout = Robot::jethexa().layout();

    println!(
        "| log | truth | GA | F [rad] | time [s] | exact | F [rad] | time [s] | legs right | \
         seeds at the optimum | as in the paper |"
    );
    println!("|:--|:--|:--|--:|--:|:--|--:|--:|:--|--:|--:|");
    for (name, truth) in truths {
        if only.is_empty() || only.contains(&name) {
            let path = folder.join(format!("{name}.csv.gz"));
            evaluate(&name, &path, &morphology(&truth, &layout)?)
                .with_context(|| path.display().to_string())?;
        }
    }
    Ok(())
}

fn morphology(truth: &Truth, layout: &LegLayout) -> anyhow::Result<Morphology> {
    let existence: Vec<bool> = truth.morphology.iter().flatten().map(|&x| x == 1).collect();
    Ok(Morphology::from_existence(layout, &existence)?)
}

fn evaluate(name: &str, path: &Path, truth: &Morphology) -> anyhow::Result<()> {
    let (robot, gait, settings) = (
        Robot::jethexa(),
        Gait::tripod(),
        IdentifySettings::default(),
    );
    let recording = read_log(path, &Columns::default())?;

    let started = Instant::now();
    let search = Search::Genetic { repeats: 1 };
    let genetic = identify(recording.clone(), &robot, &gait, &settings, search, 1, &())?;
    let genetic_s = started.elapsed().as_secs_f64();

    let measured = MeasuredWalk::new(recording, &settings)?;
    let objective = WalkObjective::new(&measured, &robot, &gait, &settings)?;
    let mut evaluations = Evaluations::new(&objective, &());
    let started = Instant::now();
    exact::search(&robot.layout(), &mut evaluations);
    let exact_s = started.elapsed().as_secs_f64();
    let (optimum, cost) = evaluations
        .best()
        .map(|(optimum, evaluation)| (optimum.clone(), evaluation.cost_rad))
        .context("no morphology was evaluated")?;
    let mut reached = |genetic: &GeneticSettings| {
        (1..=SEEDS)
            .filter(|&seed| {
                let run = genetic::search(&robot.layout(), genetic, seed, &mut evaluations);
                run.cost_rad <= cost
            })
            .count()
    };
    let by_default = reached(&settings.genetic);
    let as_in_the_paper = reached(&GeneticSettings {
        islands: 1,
        refine: false,
        ..GeneticSettings::default()
    });

    let right = |legs: &[usize]| {
        if legs == truth.damaged_legs() {
            "yes"
        } else {
            "no"
        }
    };
    println!(
        "| {name} | {} | {} | {:.1} | {genetic_s:.1} | {} | {cost:.1} | {exact_s:.0} | {} / {} | \
         {by_default} of {SEEDS} | {as_in_the_paper} of {SEEDS} |",
        truth.describe(),
        genetic.description,
        genetic.cost_rad,
        optimum.describe(),
        right(&genetic.damaged_legs),
        right(&optimum.damaged_legs()),
    );
    Ok(())
}
