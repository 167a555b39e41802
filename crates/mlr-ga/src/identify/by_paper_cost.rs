//! [`Method::Paper`](super::Method::Paper): the least F.

use mlr_model::{Morphology, Robot};
use rayon::prelude::*;

use super::{
    ALTERNATIVES, Alternative, BestFit, IdentifySettings, LogVerdict, MeasuredLog, Search, Verdict,
    paper_costs, searched::Searched,
};
use crate::{
    AnswerError, Evaluations, Progress,
    belief::{Belief, Posterior},
    paper_cost::PaperCosts,
};

/// Searches for the least F; the most frequent result of the runs is the answer.
///
/// The probabilities are the shares of the runs that ended so: the paper states no other.
pub(super) fn verdict(
    logs: &[MeasuredLog<'_>],
    robot: &Robot,
    search: Search,
    settings: &IdentifySettings,
    progress: &dyn Progress,
) -> Result<Verdict, AnswerError> {
    settings.check_on(robot)?;
    if search == Search::Atlas {
        return Err(AnswerError::AtlasForPaper);
    }
    let layout = robot.layout();
    let cost = paper_costs(logs, settings).map_err(|(_, error)| error)?;
    let mut evaluations = Evaluations::new(&cost, progress);
    let genetic = (&settings.genetic, settings.seed);
    let searched = Searched::new(&layout, search, genetic, f64::INFINITY, &mut evaluations);
    let no_walk = || AnswerError::AllDiverged {
        simulated: evaluations.len(),
    };
    let results = match search {
        Search::Ga => searched.results().to_vec(),
        _ => evaluations
            .best()
            .map(|(best, _)| (best.clone(), 1))
            .into_iter()
            .collect(),
    };
    let (best, _) = results.first().ok_or_else(no_walk)?.clone();
    let posterior = Posterior::new(
        results
            .iter()
            .map(|(result, count)| (result.clone(), (*count as f64).ln())),
    );
    let paper_fits = cost.least(&best).ok_or_else(no_walk)?;
    let belief = Belief {
        posterior,
        unexplained: settings.prior,
        something_else: 0.0,
    };
    Ok(Verdict {
        alternatives: alternatives(&best, &belief, &evaluations, &cost),
        nearest_of_legs: evaluations.nearest_of_legs(),
        locked_probability: None,
        cost_rad: paper_fits.cost_rad(),
        mean_error_deg: paper_fits.mean_error_deg(),
        logs: paper_fits
            .into_logs()
            .into_iter()
            .zip(logs)
            .map(|(paper_fit, (measured, _))| LogVerdict {
                something_else: None,
                fit: BestFit::of_conditioned(&paper_fit, measured.conditioned()),
                paper_fit,
            })
            .collect(),
        best,
        belief,
        something_else: None,
        evaluations: match search {
            Search::Ga => searched.candidates(),
            _ => evaluations.len(),
        },
        diverged: evaluations.diverged(),
        warnings: warnings(search, logs, settings),
        searched,
    })
}

fn warnings(search: Search, logs: &[MeasuredLog<'_>], settings: &IdentifySettings) -> Vec<String> {
    let mut warnings = Vec::new();
    if logs.iter().any(|(_, model)| model.atlas.is_some()) {
        warnings.push("the paper's method simulates every candidate: the atlas is not used".into());
    }
    if search != Search::Ga || settings.genetic.repeats < 2 {
        warnings.push(
            "the probabilities are shares of runs, and this was a single one; several need \
             --search ga and --repeats"
                .into(),
        );
    }
    warnings
}

/// The candidates with the next least F.
fn alternatives(
    best: &Morphology,
    belief: &Belief,
    evaluations: &Evaluations<'_>,
    cost: &PaperCosts,
) -> Vec<Alternative> {
    let next: Vec<&Morphology> = evaluations
        .ranking()
        .into_iter()
        .map(|(morphology, _)| morphology)
        .filter(|morphology| *morphology != best)
        .take(ALTERNATIVES)
        .collect();
    next.par_iter()
        .filter_map(|morphology| {
            Some(Alternative {
                morphology: (*morphology).clone(),
                cost_rad: cost.least(morphology)?.cost_rad(),
                probability: belief.of(morphology),
                locked_probability: None,
            })
        })
        .collect()
}
