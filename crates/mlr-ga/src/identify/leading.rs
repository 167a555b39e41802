use std::collections::{BTreeMap, BTreeSet};

use mlr_model::{LegLayout, Morphology};
use rayon::prelude::*;

use super::IdentifySettings;
use crate::{
    Evaluations, Progress, WalkObjective,
    evaluation::CaseFit,
    objective::{Fit, Tried},
    walks::Case,
};

/// A candidate less probable than the best by this factor, in nats, plays no part.
pub(super) const HOPELESS: f64 = 12.0;
/// After each round of variations, candidates this far behind are dropped.
const BEHIND: f64 = 8.0;
/// Variations that are tried between two looks at who still leads.
const ROUND: usize = 4;

/// What is known of a candidate under the variations that it was tried in.
#[derive(Debug, Clone)]
pub(super) struct Weighed {
    /// The cases that were worth comparing.
    pub(super) fits: Vec<CaseFit>,
    /// How many were tried.
    pub(super) tried: Tried,
    /// Logarithm of likelihood times prior, up to a constant.
    pub(super) ln_weight: f64,
}

/// Damage to so few legs is tried in any case, unless there are too many ways.
const LIKELY_LEGS: usize = 2;
const MOST_LIKELY: usize = 512;
/// Leading candidates beside which other links of the same damaged legs are tried.
const LEADING: usize = 8;
/// The most of them that are worth evaluating: three legs of three links.
const MOST_WITH_SAME_LEGS: usize = 27;

/// Evaluates what a search may have left out and no answer should: damage to few
/// legs, which is likely before any log is seen; and what the leading candidates may
/// be mistaken for, because which links of a damaged leg are gone often leaves no
/// trace, and a search that stops at the first of equals would be too sure of it.
pub(super) fn complete(
    layout: &LegLayout,
    objective: &WalkObjective<'_>,
    evaluations: &mut Evaluations<'_>,
) {
    let likely = likely_damage(layout);
    if likely.len() <= MOST_LIKELY {
        evaluate_missing(likely, objective, evaluations);
    }
    let same = evaluations
        .ranking()
        .into_iter()
        .take(LEADING)
        .flat_map(|(morphology, _)| with_same_legs(morphology))
        .collect();
    evaluate_missing(same, objective, evaluations);
}

/// The healthy robot, and all with at most [`LIKELY_LEGS`] damaged legs, unless they
/// become too many on the way.
fn likely_damage(layout: &LegLayout) -> Vec<Morphology> {
    let mut all = vec![Morphology::healthy(layout)];
    let mut begin = 0;
    for _ in 0..LIKELY_LEGS {
        let before = all.len();
        for index in begin..before {
            let morphology = all[index].clone();
            let last_damaged = morphology.damaged_legs().last().copied().unwrap_or(0);
            for leg in last_damaged..morphology.legs() {
                let states = 0..morphology.links(leg);
                all.extend(states.map(|left| morphology.clone().with_remaining(leg, left)));
            }
            if all.len() > MOST_LIKELY {
                return all;
            }
        }
        begin = before;
    }
    all
}

fn evaluate_missing(
    mut candidates: Vec<Morphology>,
    objective: &WalkObjective<'_>,
    evaluations: &mut Evaluations<'_>,
) {
    candidates.retain(|candidate| !evaluations.contains(candidate));
    let best_deg = evaluations
        .best()
        .map_or(f64::INFINITY, |(_, best)| best.cost_deg);
    let margin = objective.cost_of_ln_weight(-HOPELESS);
    evaluations.progress().expect_more(candidates.len());
    evaluations.evaluate_within(&candidates, best_deg * margin);
}

/// All morphologies with the same damaged legs, unless there are too many.
fn with_same_legs(morphology: &Morphology) -> Vec<Morphology> {
    let damaged = morphology.damaged_legs();
    let count: usize = damaged
        .iter()
        .map(|leg| morphology.links(leg - 1))
        .product();
    if count > MOST_WITH_SAME_LEGS {
        return Vec::new();
    }
    damaged.iter().fold(vec![morphology.clone()], |same, &leg| {
        same.iter()
            .flat_map(|one| {
                (0..one.links(leg - 1))
                    .map(|remaining| one.clone().with_remaining(leg - 1, remaining))
            })
            .collect()
    })
}

/// Tries the leading candidates under variations of the model: a robot differs from
/// its description, and with it what is lost may look otherwise.
///
/// A candidate's likelihood is the mean over all variations. Returns every candidate
/// that is not hopeless.
pub(super) fn weigh(
    objective: &WalkObjective<'_>,
    evaluations: &Evaluations<'_>,
    settings: &IdentifySettings,
    progress: &dyn Progress,
) -> BTreeMap<Morphology, Weighed> {
    let mut all = hopeful(objective, evaluations);
    let mut leaders: Vec<Morphology> = ranked(&all)
        .into_iter()
        .take(settings.leaders)
        .cloned()
        .collect();
    // Given up on the nominal model in one log, a case may still matter under variations.
    let skipped = skipped_on_the_nominal_model(objective, &all, &leaders);
    try_cases(objective, skipped, &mut all, progress);
    let variations: Vec<usize> = (1..settings.variations.len()).collect();
    for round in variations.chunks(ROUND) {
        let mut jobs = Vec::new();
        for leader in &leaders {
            for &variation in round {
                for &lost_links in objective.lost_links(leader) {
                    let case = Case {
                        lost_links,
                        variation,
                    };
                    jobs.extend((0..objective.logs()).map(|log| (leader.clone(), log, case)));
                }
            }
        }
        try_cases(objective, jobs, &mut all, progress);
        let best = best_of(&all);
        leaders.retain(|leader| {
            all.get(leader)
                .is_some_and(|weighed| weighed.ln_weight > best - BEHIND)
        });
    }
    all
}

/// A candidate in one case, compared with one of the logs.
type Job = (Morphology, usize, Case);

/// The cases of these candidates that were not compared with every log on the nominal model. One
/// log leaves none of them: what did not fit it then fits nothing.
fn skipped_on_the_nominal_model(
    objective: &WalkObjective<'_>,
    all: &BTreeMap<Morphology, Weighed>,
    leaders: &[Morphology],
) -> Vec<Job> {
    let mut skipped = Vec::new();
    if objective.logs() == 1 {
        return skipped;
    }
    for (leader, weighed) in leaders.iter().filter_map(|one| all.get_key_value(one)) {
        for &lost_links in objective.lost_links(leader) {
            let case = Case {
                lost_links,
                variation: 0,
            };
            let is_missing = |log: &usize| {
                let fits = &mut weighed.fits.iter();
                !fits.any(|fit| fit.log == *log && fit.case == case)
            };
            let missing = (0..objective.logs()).filter(is_missing);
            skipped.extend(missing.map(|log| (leader.clone(), log, case)));
        }
    }
    skipped
}

/// Compares candidates with logs, and brings what is known of them up to date.
fn try_cases(
    objective: &WalkObjective<'_>,
    jobs: Vec<Job>,
    all: &mut BTreeMap<Morphology, Weighed>,
    progress: &dyn Progress,
) {
    let best = best_of(all);
    progress.expect_more(jobs.len());
    let fits: Vec<Fit> = jobs
        .par_iter()
        .map(|(candidate, log, case)| {
            let fit = objective.fit(candidate, *log, *case, best - HOPELESS);
            progress.advance();
            fit
        })
        .collect();
    let mut changed = BTreeSet::new();
    for ((candidate, log, case), fit) in jobs.into_iter().zip(fits) {
        let Some(weighed) = all.get_mut(&candidate).filter(|_| fit != Fit::Unknown) else {
            continue;
        };
        // The nominal model counts as tried from the start.
        if case.variation > 0 {
            weighed.tried.add(log, case.lost_links);
        }
        if let Fit::Fits(fit) = fit {
            weighed.fits.push(fit);
        }
        changed.insert(candidate);
    }
    for candidate in changed {
        if let Some(weighed) = all.get_mut(&candidate) {
            weighed.ln_weight = objective.ln_weight(&candidate, &weighed.fits, &weighed.tried);
        }
    }
}

/// The candidates that the nominal model leaves some hope for.
fn hopeful(
    objective: &WalkObjective<'_>,
    evaluations: &Evaluations<'_>,
) -> BTreeMap<Morphology, Weighed> {
    let mut all = BTreeMap::new();
    for (morphology, evaluation) in evaluations.ranking() {
        let ln_weight = objective.ln_weight_of_cost(evaluation.cost_deg);
        if ln_weight.is_finite() {
            let weighed = Weighed {
                fits: evaluation.fits.clone(),
                tried: objective.tried_nominal(morphology),
                ln_weight,
            };
            all.insert(morphology.clone(), weighed);
        }
    }
    all
}

/// The fit of a candidate to each log in the case in which it is likeliest, what became of its lost
/// links being the same in all of them. `None` where none of its cases fits every log.
pub(super) fn likeliest_fits(
    objective: &WalkObjective<'_>,
    morphology: &Morphology,
    weighed: &Weighed,
) -> Option<Vec<CaseFit>> {
    let ln_of = |fits: &[CaseFit]| fits.iter().map(|fit| fit.ln_likelihood).sum::<f64>();
    let cases = objective.lost_links(morphology).iter();
    let each = cases.filter_map(|&lost_links| {
        let of_log = |log: usize| {
            let fits = weighed.fits.iter();
            fits.filter(|fit| fit.log == log && fit.case.lost_links == lost_links)
                .max_by(|a, b| a.ln_likelihood.total_cmp(&b.ln_likelihood))
                .copied()
        };
        (0..objective.logs())
            .map(of_log)
            .collect::<Option<Vec<_>>>()
    });
    each.max_by(|a, b| ln_of(a).total_cmp(&ln_of(b)))
}

fn best_of(all: &BTreeMap<Morphology, Weighed>) -> f64 {
    all.values()
        .map(|weighed| weighed.ln_weight)
        .fold(f64::NEG_INFINITY, f64::max)
}

fn ranked(all: &BTreeMap<Morphology, Weighed>) -> Vec<&Morphology> {
    let mut ranked: Vec<_> = all.iter().collect();
    ranked.sort_by(|(a, x), (b, y)| y.ln_weight.total_cmp(&x.ln_weight).then_with(|| b.cmp(a)));
    ranked
        .into_iter()
        .map(|(morphology, _)| morphology)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn likely_damage_is_to_few_legs_and_each_is_named_once() {
        let layout = LegLayout::new([3; 6]).unwrap();
        let mut likely = likely_damage(&layout);
        assert_eq!(likely.len(), 1 + 6 * 3 + 15 * 9);
        assert!(likely.iter().all(|one| one.damaged_legs().len() <= 2));
        likely.sort();
        likely.dedup();
        assert_eq!(likely.len(), 154);
        let millipede = LegLayout::new(vec![3; 60]).unwrap();
        assert!(likely_damage(&millipede).len() > MOST_LIKELY);
    }

    #[test]
    fn the_same_legs_are_damaged() {
        let layout = LegLayout::new([3; 6]).unwrap();
        let morphology = Morphology::parse("110 111 111 000 111 111", &layout).unwrap();
        let same = with_same_legs(&morphology);
        assert_eq!(same.len(), 9);
        assert!(same.contains(&morphology));
        assert!(same.iter().all(|one| one.damaged_legs() == [1, 4]));
        let healthy = Morphology::healthy(&layout);
        assert_eq!(with_same_legs(&healthy), [healthy]);
        let wreck = Morphology::parse("000 000 000 000 111 111", &layout).unwrap();
        assert!(with_same_legs(&wreck).is_empty());
    }
}
