//! From a recording to the damaged legs.

mod answer;
mod gait_phase;
mod leading;
mod measured_walk;
mod model_walks;
mod report;
mod settings;

pub use answer::{Alternative, BestFit, ComparedSignals, Frequency, Identification};
pub use gait_phase::{Begins, GaitPhase};
pub use measured_walk::{MeasuredWalk, Stretch};
pub use report::{IdentificationReport, SearchMethod};
pub use settings::IdentifySettings;

use std::collections::BTreeMap;

use mlr_imu::{Recording, quality::LogQuality};
use mlr_model::{Gait, Morphology, Robot};

use rayon::prelude::*;

use model_walks::ModelWalks;

use crate::{
    AnswerError, Evaluations, Progress, WalkObjective,
    atlas::Atlas,
    belief::{Belief, DamagePrior, Posterior},
    evaluation::CaseFit,
    exact, genetic, mean_error_deg,
    paper_cost::PaperCost,
};

/// How the morphologies are searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Search {
    /// The genetic algorithm, run so many times (at least once) with
    /// consecutive seeds. The most frequent result is the answer.
    Genetic {
        /// Number of runs.
        repeats: usize,
    },
    /// Every feasible morphology, simulated.
    Exact,
    /// Every feasible morphology, as the atlas has it.
    Atlas,
}

/// What is known of the robot before it is damaged.
#[derive(Debug, Clone, Copy)]
pub struct Model<'a> {
    /// The robot in full health.
    pub robot: &'a Robot,
    /// The gait that it walks.
    pub gait: &'a Gait,
    /// Its walks, if they were simulated beforehand: then nothing is simulated but
    /// what the report shows.
    pub atlas: Option<&'a Atlas>,
}

/// How many alternatives are reported.
const ALTERNATIVES: usize = 5;

/// Names the lost links of the robot that made the recording while walking
/// `gait`, and says how sure that is. Same inputs, same answer, whatever the number
/// of threads.
///
/// # Errors
/// [`AnswerError`]; [`AnswerError::is_recordings_fault`] tells a recording
/// that cannot answer from settings that make no sense.
pub fn identify(
    recording: &Recording,
    model: Model<'_>,
    settings: &IdentifySettings,
    search: Search,
    seed: u64,
    progress: &dyn Progress,
) -> Result<Identification, AnswerError> {
    let Model { robot, gait, .. } = model;
    let measured = MeasuredWalk::new(recording, gait, settings)?;
    let walks = ModelWalks::new(&measured, model, search, settings)?;
    let objective = WalkObjective::new(&measured, &walks, settings);
    let mut evaluations = Evaluations::new(&objective, progress);
    let found = Found::by(search, robot, settings, seed, &objective, &mut evaluations);
    leading::complete(&robot.layout(), &objective, &mut evaluations);
    let weighed = leading::weigh(&objective, &evaluations, settings, progress);
    let posterior = Posterior::new(
        weighed
            .iter()
            .map(|(morphology, weighed)| (morphology.clone(), weighed.ln_weight)),
    );
    let no_walk = || AnswerError::AllDiverged {
        simulated: evaluations.len(),
    };
    let best = posterior.best().ok_or_else(no_walk)?.clone();
    let fit = likeliest_fit(&weighed, &best).ok_or_else(no_walk)?;
    let fit = BestFit::new(
        fit,
        objective.motion_deg(fit.misfit.alignment),
        &settings.variations,
    );
    let paper_cost = PaperCost::new(&measured, robot, gait, settings)?;
    let (simulated, cost_rad) = paper_cost.of(&best, fit.lost_links).ok_or_else(no_walk)?;
    let mean_error_deg = mean_error_deg(cost_rad, simulated.roll.len());
    let belief = Belief {
        something_else: something_else(&fit, mean_error_deg, measured.quality(), settings),
        unexplained: DamagePrior {
            leg_damaged: settings.plausibility.leg_damaged,
            ..settings.prior
        },
        posterior,
    };
    Ok(Identification {
        morphology: best.to_rows(),
        damaged_legs: best.damaged_legs(),
        description: best.describe(),
        implausible: belief.something_else > 0.5,
        something_else_probability: belief.something_else,
        probability: belief.of(&best),
        legs_probability: belief.of_legs_of(&best),
        leg_damage_probability: belief.leg_damage(best.legs()),
        link_loss_probability: belief.link_loss((0..best.legs()).map(|leg| best.links(leg))),
        cost_rad,
        mean_error_deg,
        fit,
        alternatives: alternatives(&best, &belief, &weighed, &paper_cost),
        indistinguishable: belief
            .posterior
            .credible(settings.credible_share)
            .into_iter()
            .filter(|morphology| **morphology != best)
            .map(Morphology::to_rows)
            .collect(),
        motion_start_s: measured
            .start()
            .stood_before
            .then_some(measured.start().start_s),
        window_start_s: measured.window().start_s,
        window_s: measured.window().duration_s,
        evaluations: evaluations.len(),
        diverged: evaluations.diverged(),
        cost_per_generation: found.cost_per_generation,
        frequencies: found.frequencies,
        log_quality: measured.quality().clone(),
        warnings: measured
            .warnings()
            .iter()
            .cloned()
            .chain(model.atlas.and_then(Atlas::warning))
            .collect(),
        signals: ComparedSignals {
            rate_hz: settings.filter.rate_hz,
            measured: measured.conditioned().clone(),
            simulated,
        },
    })
}

/// Probability that something else than damage to legs decides how the robot walks, as its
/// best fit and the recording itself show.
fn something_else(
    fit: &BestFit,
    mean_error_deg: f64,
    quality: &LogQuality,
    settings: &IdentifySettings,
) -> f64 {
    let of_the_fit =
        settings
            .plausibility
            .something_else(fit.error_deg, fit.motion_deg, mean_error_deg);
    if quality.is_worse() {
        of_the_fit.max(settings.plausibility.defective_sensor)
    } else {
        of_the_fit
    }
}

/// The course of a genetic search; empty for an exact one.
#[derive(Default)]
struct Found {
    cost_per_generation: Vec<f64>,
    frequencies: Vec<Frequency>,
}

impl Found {
    fn by(
        search: Search,
        robot: &Robot,
        settings: &IdentifySettings,
        seed: u64,
        objective: &WalkObjective<'_>,
        evaluations: &mut Evaluations<'_>,
    ) -> Self {
        let layout = robot.layout();
        match search {
            Search::Exact | Search::Atlas => {
                let margin = objective.cost_of_ln_weight(-leading::HOPELESS);
                exact::search(&layout, margin, evaluations);
                Self::default()
            }
            Search::Genetic { repeats } => {
                Self::most_frequent(repeats.max(1), seed, evaluations, |seed, evaluations| {
                    genetic::search(&layout, &settings.genetic, seed, evaluations)
                })
            }
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
                    cost_deg: outcome.cost_deg,
                    count: *count,
                })
                .collect()
        } else {
            Vec::new()
        };
        let (_, answer) = by_frequency.swap_remove(0);
        Self {
            cost_per_generation: answer.cost_per_generation,
            frequencies,
        }
    }
}

/// The fit of a morphology in the case in which it is likeliest.
fn likeliest_fit(
    weighed: &BTreeMap<Morphology, leading::Weighed>,
    morphology: &Morphology,
) -> Option<CaseFit> {
    let fits = &weighed.get(morphology)?.fits;
    fits.iter()
        .max_by(|a, b| a.ln_likelihood.total_cmp(&b.ln_likelihood))
        .copied()
}

fn alternatives(
    best: &Morphology,
    belief: &Belief,
    weighed: &BTreeMap<Morphology, leading::Weighed>,
    paper_cost: &PaperCost,
) -> Vec<Alternative> {
    let leading: Vec<_> = belief
        .posterior
        .ranked()
        .iter()
        .filter(|(morphology, _)| morphology != best)
        .take(ALTERNATIVES)
        .collect();
    leading
        .par_iter()
        .filter_map(|(morphology, _)| {
            let fit = likeliest_fit(weighed, morphology)?;
            let (_, cost_rad) = paper_cost.of(morphology, fit.case.lost_links)?;
            Some(Alternative {
                morphology: morphology.to_rows(),
                cost_rad,
                probability: belief.of(morphology),
            })
        })
        .collect()
}
