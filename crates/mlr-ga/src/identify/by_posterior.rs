//! [`Method::Mlr`](super::Method::Mlr): the most probable morphology.

use mlr_imu::quality::LogQuality;
use mlr_model::{Morphology, Robot};
use rayon::prelude::*;

use super::{
    ALTERNATIVES, Alternative, BestFit, IdentifySettings, LogVerdict, MeasuredLog, Search, Verdict,
    leading, model_walks::ModelWalks, paper_costs, searched::Searched,
};
use crate::{
    AnswerError, Evaluations, Progress, WalkObjective,
    belief::{Belief, DamagePrior, Posterior},
    evaluation::CaseFit,
    paper_cost::PaperCosts,
    walks::WalkSource,
};

/// Lets the search propose candidates, weighs the leading ones over the variations of the
/// model, and takes the most probable.
pub(super) fn verdict(
    logs: &[MeasuredLog<'_>],
    robot: &Robot,
    search: Search,
    settings: &IdentifySettings,
    progress: &dyn Progress,
) -> Result<Verdict, (usize, AnswerError)> {
    let layout = robot.layout();
    let sources = logs.iter().enumerate().map(|(index, (measured, model))| {
        let walks = ModelWalks::new(measured, *model, search, settings);
        walks.map_err(|error| (index, error))
    });
    let sources = sources.collect::<Result<Vec<_>, _>>()?;
    let both = logs.iter().zip(&sources);
    let both = both.map(|((measured, _), walks)| (measured, walks as &dyn WalkSource));
    let objective = WalkObjective::of_logs(both, settings);
    let mut evaluations = Evaluations::new(&objective, progress);
    let genetic = (&settings.genetic, settings.seed);
    let margin = objective.cost_of_ln_weight(-leading::HOPELESS);
    let searched = Searched::new(&layout, search, genetic, margin, &mut evaluations);
    if settings.genetic.complete {
        leading::complete(&layout, &objective, &mut evaluations);
    }
    let weighed = leading::weigh(&objective, &evaluations, settings, progress);
    let posterior = Posterior::new(
        weighed
            .iter()
            .map(|(morphology, weighed)| (morphology.clone(), weighed.ln_weight)),
    );
    let no_walk = || {
        let simulated = evaluations.len();
        (0, AnswerError::AllDiverged { simulated })
    };
    let best = posterior.best().ok_or_else(no_walk)?.clone();
    let paper_costs = paper_costs(logs, settings)?;
    let likeliest = |morphology: &Morphology| {
        let weighed = weighed.get(morphology)?;
        leading::likeliest_fits(&objective, morphology, weighed)
    };
    let locked_probability = |morphology: &Morphology| {
        let weighed = weighed.get(morphology)?;
        objective.locked_probability(morphology, &weighed.fits, &weighed.tried)
    };
    let fits = likeliest(&best).ok_or_else(no_walk)?;
    let lost_links = fits.first().ok_or_else(no_walk)?.case.lost_links;
    let paper_fits = paper_costs.of(&best, lost_links).ok_or_else(no_walk)?;
    let [cost_rad, mean_error_deg] = [paper_fits.cost_rad(), paper_fits.mean_error_deg()];
    let each = fits.iter().zip(paper_fits.into_logs()).zip(logs);
    let verdicts = each.map(|((fit, paper_fit), (measured, _))| {
        let error_deg = objective.error_deg(&best, fit)?;
        let motion_deg = objective.motion_deg(fit)?;
        let fit = BestFit::new(
            *fit,
            measured.stretch(),
            error_deg,
            motion_deg,
            &settings.variations,
        );
        let mean_error_deg = paper_fit.mean_error_deg();
        Some(LogVerdict {
            something_else: Some(something_else(
                &fit,
                mean_error_deg,
                measured.quality(),
                settings,
            )),
            fit,
            paper_fit,
        })
    });
    let verdicts = verdicts.collect::<Option<Vec<_>>>().ok_or_else(no_walk)?;
    // The logs of one robot are not independent in this: the gravest counts.
    let something_else = verdicts
        .iter()
        .filter_map(|log| log.something_else)
        .fold(0.0, f64::max);
    let belief = Belief {
        something_else,
        unexplained: DamagePrior {
            leg_damaged: settings.plausibility.leg_damaged,
            ..settings.prior
        },
        posterior,
    };
    Ok(Verdict {
        alternatives: alternatives(&best, &belief, likeliest, locked_probability, &paper_costs),
        nearest_of_legs: evaluations.nearest_of_legs(),
        locked_probability: locked_probability(&best),
        best,
        belief,
        logs: verdicts,
        cost_rad,
        mean_error_deg,
        something_else: Some(something_else),
        evaluations: evaluations.len(),
        diverged: evaluations.diverged(),
        searched,
        warnings: atlas_warnings(logs),
    })
}

/// What the atlases lack, once each.
fn atlas_warnings(logs: &[MeasuredLog<'_>]) -> Vec<String> {
    let warnings = logs.iter().filter_map(|(_, model)| model.atlas?.warning());
    let mut warnings: Vec<String> = warnings.collect();
    warnings.dedup();
    warnings
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

fn alternatives(
    best: &Morphology,
    belief: &Belief,
    likeliest: impl Fn(&Morphology) -> Option<Vec<CaseFit>> + Sync,
    locked_probability: impl Fn(&Morphology) -> Option<f64> + Sync,
    paper_costs: &PaperCosts,
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
            let fits = likeliest(morphology)?;
            let paper_fits = paper_costs.of(morphology, fits.first()?.case.lost_links)?;
            Some(Alternative {
                morphology: morphology.clone(),
                cost_rad: paper_fits.cost_rad(),
                probability: belief.of(morphology),
                locked_probability: locked_probability(morphology),
            })
        })
        .collect()
}
