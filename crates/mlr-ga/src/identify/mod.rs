//! From a recording to the damaged legs.

mod answer;
mod gait_phase;
mod measured_walk;
mod report;
mod settings;

pub use answer::{Alternative, ComparedSignals, Frequency, Identification};
pub use gait_phase::GaitPhase;
pub use measured_walk::MeasuredWalk;
pub use report::{IdentificationReport, SearchMethod};
pub use settings::IdentifySettings;

use std::collections::BTreeMap;

use mlr_filter::OrientationSeries;
use mlr_model::{Gait, Morphology, Robot};

use crate::{AnswerError, Evaluations, Progress, WalkObjective, exact, genetic, mean_error_deg};

/// How the morphologies are searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Search {
    /// The genetic algorithm, run so many times (at least once) with
    /// consecutive seeds. The most frequent result is the answer.
    Genetic {
        /// Number of runs.
        repeats: usize,
    },
    /// Every feasible morphology.
    Exact,
}

/// How many alternatives are reported.
const ALTERNATIVES: usize = 5;

/// Names the lost links of the robot that made the recording while walking
/// `gait`. Same inputs, same answer, whatever the number of threads.
///
/// # Errors
/// [`AnswerError`]; [`AnswerError::is_recordings_fault`] tells a recording
/// that cannot answer from settings that make no sense.
pub fn identify(
    recording: OrientationSeries,
    robot: &Robot,
    gait: &Gait,
    settings: &IdentifySettings,
    search: Search,
    seed: u64,
    progress: &dyn Progress,
) -> Result<Identification, AnswerError> {
    let measured = MeasuredWalk::new(recording, settings)?;
    let objective = WalkObjective::new(&measured, robot, gait, settings)?;
    let mut evaluations = Evaluations::new(&objective, progress);
    let found = Found::by(search, robot, settings, seed, &mut evaluations);
    let no_walk = || AnswerError::AllDiverged {
        simulated: evaluations.len(),
    };
    let best = evaluations.get(&found.best).ok_or_else(no_walk)?;
    let (simulated, _) = objective
        .walk(&found.best, best.lost_links)
        .ok_or_else(no_walk)?;
    Ok(Identification {
        morphology: found.best.to_rows(),
        damaged_legs: found.best.damaged_legs(),
        description: found.best.describe(),
        lost_links: best.lost_links,
        cost_rad: best.cost_rad,
        mean_error_deg: mean_error_deg(best.cost_rad, simulated.roll.len()),
        alternatives: alternatives(&found.best, &evaluations),
        motion_start_s: measured
            .start()
            .stood_before
            .then_some(measured.start().start_s),
        window_start_s: measured.window().start_s,
        window_s: settings.window_s,
        evaluations: evaluations.len(),
        diverged: evaluations.diverged(),
        cost_per_generation: found.cost_per_generation,
        frequencies: found.frequencies,
        warnings: measured.warnings().to_vec(),
        signals: ComparedSignals {
            rate_hz: settings.filter.rate_hz,
            measured: measured.conditioned().clone(),
            simulated,
        },
    })
}

/// What a search came to.
struct Found {
    best: Morphology,
    cost_per_generation: Vec<f64>,
    frequencies: Vec<Frequency>,
}

impl Found {
    fn by(
        search: Search,
        robot: &Robot,
        settings: &IdentifySettings,
        seed: u64,
        evaluations: &mut Evaluations<'_>,
    ) -> Self {
        let layout = robot.layout();
        match search {
            Search::Exact => {
                exact::search(&layout, evaluations);
                Self::best_of(evaluations)
            }
            Search::Genetic { repeats } => {
                Self::most_frequent(repeats.max(1), seed, evaluations, |seed, evaluations| {
                    genetic::search(&layout, &settings.genetic, seed, evaluations)
                })
            }
        }
    }

    fn best_of(evaluations: &Evaluations<'_>) -> Self {
        let (best, _) = evaluations
            .best()
            .expect("every layout has at least the healthy morphology");
        Self {
            best: best.clone(),
            cost_per_generation: Vec::new(),
            frequencies: Vec::new(),
        }
    }

    /// The most frequent result of several runs, as the paper reports it; among
    /// equally frequent ones the better.
    fn most_frequent(
        repeats: usize,
        seed: u64,
        evaluations: &mut Evaluations<'_>,
        run: impl Fn(u64, &mut Evaluations<'_>) -> genetic::GeneticRun,
    ) -> Self {
        let mut results: BTreeMap<Morphology, (usize, genetic::GeneticRun)> = BTreeMap::new();
        for repeat in 0..repeats {
            let outcome = run(seed.wrapping_add(repeat as u64), evaluations);
            results
                .entry(outcome.best.clone())
                .or_insert((0, outcome))
                .0 += 1;
        }
        let mut by_frequency: Vec<_> = results.into_values().collect();
        by_frequency.sort_by(|(count_a, a), (count_b, b)| {
            count_b
                .cmp(count_a)
                .then_with(|| evaluations.order(&a.best, &b.best))
        });
        let frequencies = if repeats > 1 {
            by_frequency
                .iter()
                .map(|(count, outcome)| Frequency {
                    morphology: outcome.best.to_rows(),
                    cost_rad: outcome.cost_rad,
                    count: *count,
                })
                .collect()
        } else {
            Vec::new()
        };
        let (_, answer) = by_frequency.swap_remove(0);
        Self {
            best: answer.best,
            cost_per_generation: answer.cost_per_generation,
            frequencies,
        }
    }
}

fn alternatives(best: &Morphology, evaluations: &Evaluations<'_>) -> Vec<Alternative> {
    evaluations
        .ranking()
        .into_iter()
        .filter(|(morphology, evaluation)| *morphology != best && evaluation.cost_rad.is_finite())
        .take(ALTERNATIVES)
        .map(|(morphology, evaluation)| Alternative {
            morphology: morphology.to_rows(),
            cost_rad: evaluation.cost_rad,
        })
        .collect()
}
