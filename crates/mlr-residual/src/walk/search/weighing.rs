//! The final weights: evidence that no lucky walk decides.

use std::sync::Arc;

use super::{Judged, Search, least_ln_promise, race::likeliest, sort_judged};
use crate::{
    ln_mean,
    walk::{
        evidence::{Fit, LinearModel},
        observation::Whitening,
    },
};

/// Hypotheses with effects that are weighed so.
const MOST: usize = 8;
/// Fits of a robot without effects.
const BARE: usize = 2;

impl<'a> Search<'a, '_> {
    /// The likeliest hypotheses, each once, by the mean of their walks. The others, which have fallen
    /// behind, change as much as these do in the mean.
    pub(super) fn weighed(&self, fitted: Vec<Judged<'a>>) -> Vec<Judged<'a>> {
        let (chosen, left) = likeliest_and_others(each_once(fitted));
        self.progress.expect_more(chosen.len());
        let mut weighed = Vec::new();
        let mut changes = Vec::new();
        for on_one_robot in by_robot(chosen) {
            let known = on_one_robot.iter().map(|one| one.ln_weight);
            let known: Vec<f64> = known.collect();
            let now = self.by_mean_walks(on_one_robot);
            let change = now
                .iter()
                .zip(known)
                .map(|(one, known)| one.ln_weight - known);
            changes.extend(change.filter(|change| change.is_finite()));
            weighed.extend(now);
        }
        let mean = changes.iter().sum::<f64>() / changes.len().max(1) as f64;
        let left = left.into_iter().map(|one| Judged {
            ln_weight: one.ln_weight + mean,
            ln_promise: one.ln_promise + mean,
            ..one
        });
        weighed.into_iter().chain(left).collect()
    }

    /// Hypotheses on one robot by the mean of their walks.
    pub(super) fn by_mean_walks(&self, on_one_robot: Vec<Judged<'a>>) -> Vec<Judged<'a>> {
        let Some(first) = on_one_robot.first() else {
            return Vec::new();
        };
        let base = Arc::clone(&first.base);
        let fitted = on_one_robot.iter().map(|one| (&one.walker, &one.fit));
        let averaged = base.mean_walks(fitted, self.of_means).averaged();
        let usual = &averaged.whitening;
        let with_unknown = self.of_means.with_unknown(usual);
        let each = on_one_robot.into_iter().zip(averaged.fits);
        each.map(|(one, fit)| {
            self.progress.advance();
            match fit {
                Some(fit) => {
                    let ln_gain = Some(ln_gain_of_unknown(&fit, usual, &with_unknown));
                    Judged {
                        ln_gain_of_unknown: ln_gain,
                        ..self.judged(&base, one.walker, fit, ln_gain)
                    }
                }
                // Most of its neighbours do not walk.
                None => Judged {
                    ln_weight: f64::NEG_INFINITY,
                    ln_promise: f64::NEG_INFINITY,
                    ..one
                },
            }
        })
        .collect()
    }
}

/// Logarithm of the factor by which something unknown raises the evidence of a fit: the mean over the ways in which
/// it may act.
pub(super) fn ln_gain_of_unknown(fit: &Fit, usual: &Whitening, with_unknown: &[Whitening]) -> f64 {
    let ln = |whitening: &Whitening| {
        let Fit {
            walked,
            residual,
            jacobian,
            ..
        } = fit;
        let model = LinearModel::new(whitening, residual, &walked.z, jacobian);
        model.ln_evidence(whitening).0
    };
    ln_mean(with_unknown.iter().map(ln), with_unknown.len()) - ln(usual)
}

/// The likeliest fit of each hypothesis, the likeliest hypothesis first.
fn each_once(mut fitted: Vec<Judged<'_>>) -> Vec<Judged<'_>> {
    sort_judged(&mut fitted);
    let mut once: Vec<Judged<'_>> = Vec::new();
    for one in fitted {
        if !once.iter().any(|other| other.is_same(&one)) {
            once.push(one);
        }
    }
    once
}

/// Those that are weighed, of hypotheses in order of their likelihood, and the rest.
fn likeliest_and_others(fitted: Vec<Judged<'_>>) -> (Vec<Judged<'_>>, Vec<Judged<'_>>) {
    let least = least_ln_promise(&fitted);
    let is_bare = |k: &usize| fitted[*k].walker.hypothesis.is_bare();
    let bare = (0..fitted.len()).filter(is_bare).take(BARE);
    let mut chosen = likeliest(&fitted, MOST);
    chosen.extend(bare);
    let each = fitted.into_iter().enumerate();
    let (chosen, others): (Vec<_>, Vec<_>) =
        each.partition(|(k, one)| chosen.contains(k) && one.ln_promise > least);
    let without_index = |(_, one)| one;
    (
        chosen.into_iter().map(without_index).collect(),
        others.into_iter().map(without_index).collect(),
    )
}

fn by_robot(hypotheses: Vec<Judged<'_>>) -> Vec<Vec<Judged<'_>>> {
    let mut robots: Vec<Vec<Judged<'_>>> = Vec::new();
    for one in hypotheses {
        let on_same = |robot: &&mut Vec<Judged<'_>>| {
            robot
                .first()
                .is_some_and(|other| Arc::ptr_eq(&other.base, &one.base))
        };
        match robots.iter_mut().find(on_same) {
            Some(robot) => robot.push(one),
            None => robots.push(vec![one]),
        }
    }
    robots
}
