//! The race of hypotheses: all take a step, the likelier half goes on.

use std::sync::Arc;

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::{
    Judged, Search,
    base::Base,
    extrapolation::Extrapolation,
    proposals::{Proposal, Screened},
    screening::Start,
    sort_judged,
};
use crate::walk::hypothesis::{Placement, Walked, Walker};

/// Points from where one effect enters: its extrapolated walk says little of which is the best.
const STARTS: usize = 2;
/// Hypotheses with two effects of the same two kinds that enter.
const PAIRS_OF_A_KIND: usize = 6;
/// So many take slopes of their own, the others those of the base.
const REFINED: usize = 6;
/// Steps on slopes of their own, at most: a fit stops where it has converged.
pub(super) const LAST_STEPS: usize = 5;

impl<'a> Search<'a, '_> {
    /// So many of the most promising, each walked where its linear model is likeliest.
    pub(super) fn entrants(
        &self,
        screened: &[Screened<'a>],
        ranked: Vec<Proposal>,
        most: usize,
    ) -> Vec<Judged<'a>> {
        let chosen = chosen(screened, ranked, most);
        self.progress.expect_more(chosen.len());
        let mut entrants: Vec<Judged<'a>> = chosen
            .par_iter()
            .filter_map(|proposal| {
                let on = &screened[proposal.base];
                let starts: Vec<&Start> = proposal.starts.iter().map(|k| &on.starts[*k]).collect();
                let judged = self.entered(&on.base, &starts);
                self.progress.advance();
                judged
            })
            .collect();
        sort_judged(&mut entrants);
        let mut apart: Vec<Judged<'a>> = Vec::new();
        for entrant in entrants {
            let is_known = apart.iter().any(|other| other.is_same(&entrant));
            if !is_known {
                apart.push(entrant);
            }
        }
        apart
    }

    fn entered(&self, base: &Arc<Base<'a>>, starts: &[&Start]) -> Option<Judged<'a>> {
        let walker = base.with(starts.iter().map(|start| start.placement).collect());
        let whitening = &base.whitening;
        let [held, free] = [true, false].map(|held| base.simulated.with(starts, &walker, held));
        let at_optimum = |linear: &Extrapolation<'_>| {
            let (_, mut z) = linear.ln_evidence(whitening);
            walker.clamp(&mut z);
            z
        };
        // Without the effect, parameters of the body stood in for it: one begins at the body as
        // described.
        let near = at_optimum(&held);
        let body_described = walker.with_body_described(near.clone());
        // A body that already walks like the measured one stays as it is: the walk is no smooth function
        // of all its parameters.
        let mut body_kept = walker.at_kept_body(&free.model, whitening);
        walker.clamp(&mut body_kept);
        let points = vec![near, at_optimum(&free), body_described, body_kept];
        let walked = walker.likelier(points, whitening)?;
        Some(self.begun(base, walker, walked, &base.jacobian))
    }

    /// A hypothesis where it enters.
    pub(super) fn begun(
        &self,
        base: &Arc<Base<'a>>,
        walker: Walker<'a>,
        walked: Walked,
        known: &DMatrix<f64>,
    ) -> Judged<'a> {
        let fit = walker.begun(walked, known, &base.whitening);
        self.judge(base, walker, fit)
    }

    /// Every entrant as far as it came, the likeliest first. Those without effects stay to the end:
    /// effects get no credit for a longer search. What cannot win any more stays where it is.
    pub(super) fn race(&self, mut running: Vec<Judged<'a>>) -> Vec<Judged<'a>> {
        let mut left_behind: Vec<Judged<'a>> = Vec::new();
        let mut most = running.len();
        while most > REFINED {
            most = most.div_ceil(2).max(REFINED);
            running = keep_likeliest(running, most, &mut left_behind);
            if most > REFINED {
                running = self.each(running, |one| Some(self.advanced(one)));
            }
        }
        running = self.each(running, |one| Some(self.refined(one)));
        running.extend(left_behind);
        sort_judged(&mut running);
        running
    }

    pub(super) fn each(
        &self,
        running: Vec<Judged<'a>>,
        further: impl Fn(&Judged<'a>) -> Option<Judged<'a>> + Sync,
    ) -> Vec<Judged<'a>> {
        self.progress.expect_more(running.len());
        let least = self.least_ln_promise(&running);
        running
            .into_par_iter()
            .map(|one| {
                let may_win = one.ln_promise > least;
                let better = may_win.then(|| further(&one)).flatten();
                self.progress.advance();
                better.unwrap_or(one)
            })
            .collect()
    }

    pub(super) fn advanced(&self, judged: &Judged<'a>) -> Judged<'a> {
        let Judged {
            base, walker, fit, ..
        } = judged;
        let (walked, jacobian) = (fit.walked.clone(), fit.jacobian.clone());
        let fit = walker.advanced(walked, jacobian, &base.whitening, 1);
        self.judge(base, walker.clone(), fit)
    }

    /// With slopes of its own.
    fn refined(&self, judged: &Judged<'a>) -> Judged<'a> {
        let Judged {
            base, walker, fit, ..
        } = judged;
        let jacobian = walker.jacobian(&fit.walked);
        let fit = walker.advanced(fit.walked.clone(), jacobian, &base.whitening, LAST_STEPS);
        self.judge(base, walker.clone(), fit)
    }
}

/// The first of these proposals, but not too many that are much alike.
fn chosen(screened: &[Screened<'_>], ranked: Vec<Proposal>, most: usize) -> Vec<Proposal> {
    let mut chosen: Vec<Proposal> = Vec::new();
    for proposal in ranked {
        let effects = proposal.placements(screened);
        let is_same =
            |other: &Proposal| other.base == proposal.base && other.placements(screened) == effects;
        let is_of_kinds = |other: &Proposal| {
            let others = other.placements(screened);
            let kinds = others.iter().map(|placed| placed.effect.kind());
            kinds.eq(effects.iter().map(|placed| placed.effect.kind()))
        };
        let same = chosen.iter().filter(|other| is_same(other)).count();
        let of_kinds = || chosen.iter().filter(|other| is_of_kinds(other)).count();
        let may_enter = match effects.len() {
            1 => same < STARTS,
            _ => same == 0 && of_kinds() < PAIRS_OF_A_KIND,
        };
        if may_enter && chosen.len() < most {
            chosen.push(proposal);
        }
    }
    chosen
}

/// The so many likeliest, up to half of them the likeliest of each robot, and those without effects; the others go to
/// `left_behind`.
fn keep_likeliest<'a>(
    mut running: Vec<Judged<'a>>,
    most: usize,
    left_behind: &mut Vec<Judged<'a>>,
) -> Vec<Judged<'a>> {
    sort_judged(&mut running);
    let mut chosen = likeliest_of_each_robot(&running, most / 2);
    for k in likeliest(&running, most) {
        if chosen.len() < most && !chosen.contains(&k) {
            chosen.push(k);
        }
    }
    let (stay, go): (Vec<_>, Vec<_>) = running
        .into_iter()
        .enumerate()
        .partition(|(k, one)| chosen.contains(k) || one.hypothesis().is_bare());
    left_behind.extend(go.into_iter().map(|(_, one)| one));
    stay.into_iter().map(|(_, one)| one).collect()
}

/// Indices of the likeliest hypothesis with effects on each robot, of those on so many robots, `ranked` by their weights.
fn likeliest_of_each_robot(ranked: &[Judged<'_>], most: usize) -> Vec<usize> {
    let mut chosen: Vec<usize> = Vec::new();
    for (k, one) in ranked.iter().enumerate() {
        let is_on_robot = |c: &usize| Arc::ptr_eq(&ranked[*c].base, &one.base);
        if chosen.len() < most && !one.hypothesis().is_bare() && !chosen.iter().any(is_on_robot) {
            chosen.push(k);
        }
    }
    chosen
}

/// Indices of so many likeliest of those with effects, `ranked` by their weights. Half of the places
/// are for those that do not merely add an effect to one that is chosen: else the many that add to
/// the likeliest would leave none to what else it may be.
pub(super) fn likeliest(ranked: &[Judged<'_>], most: usize) -> Vec<usize> {
    let with_effects = || {
        let each = ranked.iter().enumerate();
        each.filter(|(_, one)| !one.hypothesis().is_bare())
    };
    let mut chosen: Vec<usize> = Vec::new();
    for (k, one) in with_effects() {
        if chosen.len() < most.div_ceil(2) && !chosen.iter().any(|c| one.extends(&ranked[*c])) {
            chosen.push(k);
        }
    }
    for (k, _) in with_effects() {
        if chosen.len() < most && !chosen.contains(&k) {
            chosen.push(k);
        }
    }
    chosen
}

impl Proposal {
    fn placements(&self, screened: &[Screened<'_>]) -> Vec<Placement> {
        let starts = &screened[self.base].starts;
        self.starts.iter().map(|k| starts[*k].placement).collect()
    }
}

impl Judged<'_> {
    /// Whether it has all effects of another, and more.
    fn extends(&self, other: &Self) -> bool {
        let (own, others) = (
            &self.walker.hypothesis.effects,
            &other.walker.hypothesis.effects,
        );
        Arc::ptr_eq(&self.base, &other.base)
            && own.len() > others.len()
            && others.iter().all(|one| own.contains(one))
    }

    pub(super) fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.base, &other.base)
            && self.walker.hypothesis.effects == other.walker.hypothesis.effects
    }

    /// Whether it is weighed by the mean of its walks.
    pub(super) fn is_weighed(&self) -> bool {
        self.ln_without_and_with_unknown.is_some()
    }
}
