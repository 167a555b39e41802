//! Hypotheses next to the likeliest: one effect more.

use std::sync::Arc;

use rayon::prelude::*;

use super::{
    Judged, Search, least_ln_weight,
    proposals::Screened,
    screening::{self, Start},
    sort_judged,
};
use crate::walk::evidence::{LinearModel, ln_evidence};

/// Times that the likeliest hypothesis is looked at, as long as it is another one.
const TIMES: usize = 2;
/// Effects that are weighed beside a hypothesis, at most.
const MOST: usize = 6;
/// What promises a smaller share of the weight of the likeliest is not weighed.
const LEAST_SHARE: f64 = 0.02;

impl<'a> Search<'a, '_> {
    /// These hypotheses, weighed over the whole stretch, and those that one effect more makes of the likeliest,
    /// and of its robot without effects.
    ///
    /// The race looks at the beginning of the walk, and the robot that is likeliest there need not be the
    /// likeliest in the end: what may be wrong with that one was not tried then.
    pub(super) fn with_neighbours(&self, mut weighed: Vec<Judged<'a>>) -> Vec<Judged<'a>> {
        let mut seen: Vec<Judged<'a>> = Vec::new();
        let mut screened: Vec<Screened<'a>> = Vec::new();
        for _ in 0..TIMES {
            sort_judged(&mut weighed);
            let Some(likeliest) = weighed.first() else {
                break;
            };
            let on_its_robot = weighed.iter().filter(|one| {
                let is_bare = one.walker.hypothesis.is_bare();
                one.is_same(likeliest) || (is_bare && Arc::ptr_eq(&one.base, &likeliest.base))
            });
            let least = least_ln_weight(&weighed);
            let looked_at: Vec<Judged<'a>> = on_its_robot
                .filter(|one| one.walker.hypothesis.effects.len() < self.effort.most_effects)
                .filter(|one| one.ln_weight > least && !seen.iter().any(|s| s.is_same(one)))
                .cloned()
                .collect();
            let Some(first) = looked_at.first() else {
                break;
            };
            let is_same = |on: &Screened<'a>| Arc::ptr_eq(&on.base, &first.base);
            let known = screened.iter().position(is_same).unwrap_or_else(|| {
                screened.push(Screened {
                    starts: screening::starts(&first.base, self.progress),
                    base: Arc::clone(&first.base),
                });
                screened.len() - 1
            });
            let starts = &screened[known].starts;
            let least = likeliest.ln_weight + LEAST_SHARE.ln();
            let beside = |one| self.with_promising(one, starts, &weighed, least);
            let group: Vec<Judged<'a>> = looked_at.iter().flat_map(beside).collect();
            seen.extend(looked_at);
            self.progress.expect_more(group.len());
            let again = self.by_mean_walks(group);
            weighed.retain(|one| !again.iter().any(|other| other.is_same(one)));
            weighed.extend(again);
        }
        weighed
    }

    /// A hypothesis and what the effects that promise most make of it; nothing where none does.
    fn with_promising(
        &self,
        one: &Judged<'a>,
        starts: &[Start],
        weighed: &[Judged<'a>],
        least: f64,
    ) -> Vec<Judged<'a>> {
        let promising = self.promising_beside(one, starts, weighed, least);
        if promising.is_empty() {
            return Vec::new();
        }
        self.progress.expect_more(promising.len());
        let mut group = vec![one.clone()];
        group.par_extend(promising.into_par_iter().filter_map(|start| {
            let extended = self.extended(one, start);
            self.progress.advance();
            extended
        }));
        group
    }

    /// The starts of effects that promise most beside a hypothesis, one each, by the linear model of its
    /// walk: those that were not weighed, with more than `least` for a weight.
    fn promising_beside<'s>(
        &self,
        judged: &Judged<'a>,
        starts: &'s [Start],
        weighed: &[Judged<'a>],
        least: f64,
    ) -> Vec<&'s Start> {
        let Judged { base, fit, .. } = judged;
        let (ln_without, _) =
            ln_evidence(&base.whitening, &fit.residual, &fit.walked.z, &fit.jacobian);
        let ln_prior_without = self.ln_prior(base, &judged.walker);
        let promised = |start: &'s Start| -> Option<(&'s Start, f64)> {
            if judged.walker.hypothesis.effects.contains(&start.placement) {
                return None;
            }
            let walker = base.with_added(&judged.walker, start.placement);
            let is_known = weighed.iter().any(|one| {
                Arc::ptr_eq(&one.base, base) && one.walker.hypothesis.is_same(&walker.hypothesis)
            });
            if is_known {
                return None;
            }
            let linear = LinearModel {
                held: 0,
                ..base.linear_beside(&walker, fit, start)
            };
            let gain = linear.ln_evidence(&base.whitening).0 - ln_without
                + self.ln_prior(base, &walker)
                - ln_prior_without;
            let ln_weight = judged.ln_weight + gain;
            (ln_weight > least).then_some((start, ln_weight))
        };
        let mut ranked: Vec<(&Start, f64)> = starts.par_iter().filter_map(promised).collect();
        ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mut chosen: Vec<&Start> = Vec::new();
        for (start, _) in ranked {
            let is_chosen = chosen
                .iter()
                .any(|other| other.placement == start.placement);
            if chosen.len() < MOST && !is_chosen {
                chosen.push(start);
            }
        }
        chosen
    }
}
