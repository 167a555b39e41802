//! What each part of the genetic algorithm is worth: how often it ends at the optimum of the
//! deciding cost that the exact search finds, ten seeds on each log of the directories, with the
//! default settings and with one part changed at a time. Prints a Markdown table. Walks come
//! from an atlas, so that the exact optimum is known at once.
//!
//! ```text
//! cargo run --release -p mlr-ga --example genetic_convergence -- ATLAS DIR…
//! ```
#![allow(clippy::print_stdout, reason = "the table is what this program is for")]

use std::{
    fs,
    path::{Path, PathBuf},
};

use anyhow::Context;
use mlr_ga::{
    Evaluations, IdentifySettings, MeasuredWalk, WalkObjective,
    atlas::Atlas,
    exact,
    genetic::{self, CrossoverUnit, GeneticSettings},
};
use mlr_imu::{Columns, read_log};
use mlr_model::{Gait, Robot};

const SEEDS: u64 = 10;
/// An optimum with so many damaged legs lies beyond what is tried in any case.
const MANY_LEGS: usize = 3;

/// The default settings, and one part changed at a time.
fn variants() -> Vec<(&'static str, GeneticSettings)> {
    let default = GeneticSettings::default();
    let evolution = GeneticSettings {
        refine: false,
        ..default.clone()
    };
    vec![
        ("default", default.clone()),
        (
            "one island",
            GeneticSettings {
                islands: 1,
                ..default.clone()
            },
        ),
        ("no local search", evolution.clone()),
        (
            "no local search, no crossover",
            GeneticSettings {
                crossover_rate: 0.0,
                ..evolution.clone()
            },
        ),
        (
            "no local search, no mutation",
            GeneticSettings {
                mutation_rate: 0.0,
                ..evolution.clone()
            },
        ),
        (
            "no local search, crossover by link",
            GeneticSettings {
                crossover_unit: CrossoverUnit::Link,
                ..evolution.clone()
            },
        ),
        (
            "no local search, children may repeat",
            GeneticSettings {
                novel: false,
                ..evolution.clone()
            },
        ),
        (
            "no evolution: random candidates, local search",
            GeneticSettings {
                population: 110,
                generations: 0,
                ..default
            },
        ),
        ("the paper's", GeneticSettings::paper()),
        (
            "the paper's, children never repeat",
            GeneticSettings {
                novel: true,
                ..GeneticSettings::paper()
            },
        ),
        (
            "as many random candidates",
            GeneticSettings {
                population: 110,
                generations: 0,
                ..GeneticSettings::paper()
            },
        ),
    ]
}

/// How often the optimum was found.
#[derive(Debug, Clone, Default)]
struct Hits {
    found: usize,
    runs: usize,
    evaluations: usize,
}

fn main() -> anyhow::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let atlas = arguments.next().context("expected an atlas")?;
    let (robot, gait) = (Robot::jethexa(), Gait::tripod());
    let settings = IdentifySettings::default();
    let atlas = Atlas::open(Path::new(&atlas), &robot, &gait, &settings)?;
    let layout = robot.layout();
    let variants = variants();
    // Few and many damaged legs.
    let mut hits = vec![[Hits::default(), Hits::default()]; variants.len()];
    for directory in arguments {
        for log in logs(Path::new(&directory))? {
            let recording = read_log(&log, &Columns::default())?;
            let Ok(measured) = MeasuredWalk::new(&recording, &gait, &settings) else {
                continue;
            };
            let objective = WalkObjective::new(&measured, &atlas, &settings);
            let mut all = Evaluations::new(&objective, &());
            exact::search(&layout, f64::INFINITY, &mut all);
            let (optimum, best) = all.best().context("no morphology was evaluated")?;
            let group = usize::from(optimum.damaged_legs().len() >= MANY_LEGS);
            for ((_, genetic), hits) in variants.iter().zip(&mut hits) {
                for seed in 1..=SEEDS {
                    let mut evaluations = Evaluations::new(&objective, &());
                    let run = genetic::search(&layout, genetic, seed, &mut evaluations);
                    let hits = &mut hits[group];
                    hits.found += usize::from(run.cost_deg <= best.cost_deg);
                    hits.runs += 1;
                    hits.evaluations += evaluations.len();
                }
            }
        }
    }
    println!(
        "| settings | up to 2 legs: optimum found | evaluations | 3 legs and more | evaluations |"
    );
    println!("|:--|--:|--:|--:|--:|");
    for ((name, _), hits) in variants.iter().zip(&hits) {
        let cells: Vec<String> = hits
            .iter()
            .map(|hits| {
                let runs = hits.runs.max(1);
                let share = 10.0 * hits.found as f64 / runs as f64;
                format!("{share:.1} of 10 | {}", hits.evaluations / runs)
            })
            .collect();
        println!("| {name} | {} |", cells.join(" | "));
    }
    Ok(())
}

/// The logs of a directory, by name.
fn logs(directory: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let mut logs: Vec<PathBuf> = fs::read_dir(directory)
        .with_context(|| directory.display().to_string())?
        .map(|entry| Ok(entry?.path()))
        .collect::<anyhow::Result<_>>()?;
    logs.retain(|path| path.to_string_lossy().ends_with(".csv.gz"));
    logs.sort();
    Ok(logs)
}
