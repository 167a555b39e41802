//! [`Method::Mlr`](super::Method::Mlr): the most probable morphology.

use std::collections::BTreeMap;

use mlr_imu::quality::LogQuality;
use mlr_model::Morphology;
use rayon::prelude::*;

use super::{
    ALTERNATIVES, Alternative, BestFit, IdentifySettings, MeasuredWalk, Search, Verdict, leading,
    model_walks::ModelWalks, searched::Searched,
};
use crate::{
    AnswerError, Evaluations, Model, Progress, WalkObjective,
    atlas::Atlas,
    belief::{Belief, DamagePrior, Posterior},
    evaluation::CaseFit,
    paper_cost::PaperCost,
};

/// Lets the search propose candidates, weighs the leading ones over the variations of the
/// model, and takes the most probable.
pub(super) fn verdict(
    measured: &MeasuredWalk,
    model: Model<'_>,
    search: Search,
    settings: &IdentifySettings,
    progress: &dyn Progress,
) -> Result<Verdict, AnswerError> {
    let layout = model.robot.layout();
    let walks = ModelWalks::new(measured, model, search, settings)?;
    let objective = WalkObjective::new(measured, &walks, settings);
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
    let no_walk = || AnswerError::AllDiverged {
        simulated: evaluations.len(),
    };
    let best = posterior.best().ok_or_else(no_walk)?.clone();
    let fit = likeliest_fit(&weighed, &best).ok_or_else(no_walk)?;
    let fit = BestFit::new(
        fit,
        objective.error_deg(&best, &fit).ok_or_else(no_walk)?,
        objective.motion_deg(fit.misfit.alignment),
        &settings.variations,
    );
    let paper_cost = PaperCost::new(measured, model.robot, model.gait, settings)?;
    let paper_fit = paper_cost.of(&best, fit.lost_links).ok_or_else(no_walk)?;
    let mean_error_deg = paper_fit.mean_error_deg();
    let something_else = something_else(&fit, mean_error_deg, measured.quality(), settings);
    let belief = Belief {
        something_else,
        unexplained: DamagePrior {
            leg_damaged: settings.plausibility.leg_damaged,
            ..settings.prior
        },
        posterior,
    };
    Ok(Verdict {
        alternatives: alternatives(&best, &belief, &weighed, &paper_cost),
        best,
        belief,
        something_else: Some(something_else),
        fit,
        paper_fit,
        evaluations: evaluations.len(),
        diverged: evaluations.diverged(),
        searched,
        warnings: model.atlas.and_then(Atlas::warning).into_iter().collect(),
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
            let paper_fit = paper_cost.of(morphology, fit.case.lost_links)?;
            Some(Alternative {
                morphology: morphology.clone(),
                cost_rad: paper_fit.cost_rad,
                probability: belief.of(morphology),
            })
        })
        .collect()
}
