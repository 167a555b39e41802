//! How the genetic algorithm converges, against the exact optimum: ten seeds on each
//! log of a directory, with default settings, and with a single population and no
//! local search as in the paper. Prints two Markdown tables. Walks come from an
//! atlas, so that the exact optimum is known at once.
//!
//! ```text
//! cargo run --release -p mlr-ga --example genetic_convergence -- ATLAS DIR
//! ```
#![allow(clippy::print_stdout, reason = "the table is what this program is for")]

use std::path::Path;

use anyhow::Context;
use mlr_ga::{
    Evaluations, IdentifySettings, MeasuredWalk, WalkObjective,
    atlas::Atlas,
    exact,
    genetic::{self, GeneticRun, GeneticSettings},
    scoring::read_truths,
};
use mlr_imu::{Columns, read_log};
use mlr_model::{Gait, Robot};

const SEEDS: u64 = 10;

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let atlas = arguments.next().context("expected an atlas")?;
    let directory = arguments.next().context("expected a directory of logs")?;
    let (robot, gait) = (Robot::jethexa(), Gait::tripod());
    let settings = IdentifySettings::default();
    let atlas = Atlas::open(Path::new(&atlas), &robot, &gait, &settings)?;
    let as_in_the_paper = GeneticSettings {
        islands: 1,
        refine: false,
        ..GeneticSettings::default()
    };

    let mut courses = String::new();
    println!("| log | optimum [°] | seeds at the optimum | as in the paper | evaluations |");
    println!("|:--|--:|--:|--:|--:|");
    for truth in read_truths(Path::new(&directory), &robot.layout())? {
        let recording = read_log(&truth.log, &Columns::default())?;
        let measured = MeasuredWalk::new(&recording, &gait, &settings)?;
        let objective = WalkObjective::new(&measured, &atlas, &settings);
        let mut all = Evaluations::new(&objective, &());
        exact::search(&robot.layout(), f64::INFINITY, &mut all);
        let (_, optimum) = all.best().context("no morphology was evaluated")?;
        let optimum_deg = optimum.cost_deg;
        let mut evaluated = 0;
        let mut runs = |genetic: &GeneticSettings| -> Vec<GeneticRun> {
            (1..=SEEDS)
                .map(|seed| {
                    let mut evaluations = Evaluations::new(&objective, &());
                    let run = genetic::search(&robot.layout(), genetic, seed, &mut evaluations);
                    evaluated = evaluated.max(evaluations.len());
                    run
                })
                .collect()
        };
        let by_default = runs(&settings.genetic);
        let in_the_paper = runs(&as_in_the_paper);
        let reached = |runs: &[GeneticRun]| {
            runs.iter()
                .filter(|run| run.cost_deg <= optimum_deg)
                .count()
        };
        println!(
            "| {} | {optimum_deg:.3} | {} of {SEEDS} | {} of {SEEDS} | {evaluated} |",
            truth.name,
            reached(&by_default),
            reached(&in_the_paper),
        );
        courses += &course(&truth.name, &by_default);
    }
    println!("\nBest cost in degrees after each generation, mean of the seeds:\n");
    println!("| log | 0 | 2 | 5 | 10 | 20 | local search |");
    println!("|:--|--:|--:|--:|--:|--:|--:|");
    print!("{courses}");
    Ok(())
}

fn course(name: &str, runs: &[GeneticRun]) -> String {
    let mean_at = |generation: usize| {
        let costs = runs.iter().map(|run| {
            let costs = &run.cost_per_generation;
            costs[generation.min(costs.len() - 1)]
        });
        costs.sum::<f64>() / runs.len() as f64
    };
    let columns: Vec<String> = [0, 2, 5, 10, 20, usize::MAX]
        .map(|generation| format!("{:.3}", mean_at(generation)))
        .into();
    format!("| {name} | {} |\n", columns.join(" | "))
}
