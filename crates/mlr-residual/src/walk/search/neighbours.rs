//! Hypotheses next to the likeliest: one effect more.

use std::sync::Arc;

use rayon::prelude::*;

use super::{
    Judged, Search,
    extrapolation::Simulated,
    proposals::Screened,
    screening::{self, Start},
    sort_judged,
    weighing::Weighed,
};

/// Times that the likeliest hypothesis is looked at, as long as it is another one.
const TIMES: usize = 2;
/// What promises a smaller share of the weight of the likeliest is not weighed.
const LEAST_SHARE: f64 = 0.02;

impl<'a> Search<'a, '_> {
    /// These hypotheses, weighed over the whole stretch, and those that one effect more makes of the likeliest,
    /// and of its robot without effects.
    ///
    /// The race looks at the beginning of the walk, and the robot that is likeliest there need not be the
    /// likeliest in the end: what may be wrong with that one was not tried then. However hopeless its robot is without
    /// effects, another one may explain it better.
    pub(super) fn with_neighbours(&self, mut weighed: Weighed<'a>) -> Weighed<'a> {
        let mut seen: Vec<Judged<'a>> = Vec::new();
        let mut screened: Vec<Screened<'a>> = Vec::new();
        for _ in 0..TIMES {
            let all = weighed.all();
            let Some(likeliest) = all.first() else {
                break;
            };
            let on_its_robot = all.iter().filter(|one| {
                let is_bare = one.hypothesis().is_bare();
                one.is_same(likeliest) || (is_bare && Arc::ptr_eq(&one.base, &likeliest.base))
            });
            let least = self.least_ln_promise(&all);
            let looked_at: Vec<Judged<'a>> = on_its_robot
                .filter(|one| one.hypothesis().effects.len() < self.effort.most_effects)
                .filter(|one| one.ln_promise > least || one.hypothesis().is_bare())
                .filter(|one| !seen.iter().any(|known| known.is_same(one)))
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
            let beside = |one| self.promising_beside(one, starts, &all, least);
            let mut group: Vec<Judged<'a>> = looked_at.iter().flat_map(beside).collect();
            let not_weighed = |one: &&Judged<'a>| !one.is_weighed();
            group.extend(looked_at.iter().filter(not_weighed).cloned());
            self.progress.expect_more(group.len());
            self.weigh_too(&mut weighed, group, &looked_at);
            seen.extend(looked_at);
        }
        weighed
    }

    /// What the effects that promise more than `least` make of a hypothesis.
    fn promising_beside(
        &self,
        one: &Judged<'a>,
        starts: &[Start],
        weighed: &[Judged<'a>],
        least: f64,
    ) -> Vec<Judged<'a>> {
        let simulated = Simulated::new(&one.fit, &one.base.whitening);
        let likeliest_starts = self.likeliest_beside(one, &simulated, starts, weighed);
        self.progress.expect_more(likeliest_starts.len());
        let walked = likeliest_starts.par_iter().map(|(start, _)| {
            let extended = self.extended(one, &simulated, start);
            self.progress.advance();
            extended
        });
        let mut walked: Vec<Option<Judged<'a>>> = walked.collect();
        let single = self.by_single_walk(one);
        let promises = |ln_weight: f64| one.ln_weight + ln_weight - single.ln_weight > least;
        // A single walk is rough: what promises most by extrapolation from a mean of walks is not lost by one.
        let first = match likeliest_starts.first() {
            Some((_, ln_weight)) if promises(*ln_weight) => walked[0].take(),
            _ => None,
        };
        let mut walked: Vec<Judged<'a>> = walked.into_iter().flatten().collect();
        sort_judged(&mut walked);
        walked.truncate(self.effort.neighbours.div_ceil(2));
        let mut promising = self.each(walked, |one| Some(self.advanced(one)));
        promising.retain(|other| promises(other.ln_weight));
        sort_judged(&mut promising);
        promising.truncate(self.effort.neighbours.div_ceil(4));
        promising.extend(first);
        promising
    }

    /// A hypothesis as those are judged that were not weighed by the mean of their walks.
    fn by_single_walk(&self, one: &Judged<'a>) -> Judged<'a> {
        let Judged {
            base, walker, fit, ..
        } = one;
        let (walked, jacobian) = (fit.walked.clone(), fit.jacobian.clone());
        let fit = walker.integrated(walked, jacobian, &base.whitening);
        self.judge(base, walker.clone(), fit)
    }

    /// The starts of effects that are likeliest beside a hypothesis by extrapolation, one for each, the
    /// likeliest first, with the logarithms of their weights; without those that were weighed.
    fn likeliest_beside<'s>(
        &self,
        judged: &Judged<'a>,
        simulated: &Simulated,
        starts: &'s [Start],
        weighed: &[Judged<'a>],
    ) -> Vec<(&'s Start, f64)> {
        let base = &judged.base;
        let extrapolated = |start: &'s Start| -> Option<(&'s Start, f64)> {
            if judged.hypothesis().effects.contains(&start.placement) {
                return None;
            }
            let walker = base.with_added(&judged.walker, start.placement);
            let is_known = weighed.iter().any(|one| {
                Arc::ptr_eq(&one.base, base) && one.hypothesis().is_same(&walker.hypothesis)
            });
            if is_known {
                return None;
            }
            let linear = simulated.with(&[start], &walker, false);
            let (ln_evidence, _) = linear.ln_evidence(&base.whitening);
            Some((start, ln_evidence + self.ln_prior(base.ln_prior, &walker)))
        };
        let mut ranked: Vec<(&Start, f64)> = starts.par_iter().filter_map(extrapolated).collect();
        ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mut chosen: Vec<(&Start, f64)> = Vec::new();
        for (start, ln_weight) in ranked {
            let is_chosen = chosen
                .iter()
                .any(|(other, _)| other.placement == start.placement);
            if chosen.len() < self.effort.neighbours && !is_chosen {
                chosen.push((start, ln_weight));
            }
        }
        chosen
    }

    /// A hypothesis with an effect more, walked where the linear model of its walk is likeliest.
    fn extended(
        &self,
        judged: &Judged<'a>,
        simulated: &Simulated,
        added: &Start,
    ) -> Option<Judged<'a>> {
        let base = &judged.base;
        let walker = base.with_added(&judged.walker, added.placement);
        let linear = simulated.with(&[added], &walker, true);
        let (_, at_optimum) = linear.ln_evidence(&base.whitening);
        let body_kept = walker.at_kept_body(&linear.model, &base.whitening);
        let points = [at_optimum, body_kept].map(|mut z| {
            walker.clamp(&mut z);
            z
        });
        let walked = walker.likelier(points.into(), &base.whitening)?;
        Some(self.begun(base, walker, walked, &judged.fit.jacobian))
    }
}
