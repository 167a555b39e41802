//! Robots next to the likeliest: with other links of one leg, or with lost links that hang on where they were gone.

use std::sync::Arc;

use mlr_model::{LostLinks, Morphology};
use nalgebra::DVector;
use rayon::prelude::*;

use super::{
    HOPELESS, Judged, Search,
    base::Base,
    extrapolation::Simulated,
    weighing::{IN_QUESTION, Weighed},
};
use crate::walk::{
    evidence::Fit,
    hypothesis::{Hypothesis, Placement, Walker},
};

/// Times that the likeliest robot is looked at, as long as it is another one.
const TIMES: usize = 2;
/// Robots that take steps with the slopes of the likeliest.
const STEPPED: usize = 6;
const STEPS: usize = 2;
/// Robots of these that are fitted and weighed.
const FITTED: usize = 2;

/// A hypothesis on another robot than the likeliest, with the same effects and as sensitive.
struct OnOther<'a> {
    walker: Walker<'a>,
    fit: Fit,
    ln_weight: f64,
}

impl<'a> Search<'a, '_> {
    /// These hypotheses and those on robots whose links are nearly the likeliest one's, as far as these come near it;
    /// on each robot that is weighed, the effects of the likeliest hypothesis too.
    ///
    /// Identification and the first steps know no effects: with one, another robot may be the likeliest.
    pub(super) fn with_other_links(&self, mut weighed: Weighed<'a>) -> Weighed<'a> {
        let mut seen: Vec<Arc<Base<'a>>> = Vec::new();
        for _ in 0..TIMES {
            let all = weighed.all();
            let Some(likeliest) = all.first() else {
                break;
            };
            if seen.iter().any(|base| Arc::ptr_eq(base, &likeliest.base)) {
                break;
            }
            seen.push(Arc::clone(&likeliest.base));
            let known = robots_weighed(&all);
            for base in known
                .iter()
                .filter(|one| !Arc::ptr_eq(one, &likeliest.base))
            {
                let same_effects = self.with_effects_of(likeliest, base, Vec::new());
                let is_new = |one: &Judged<'a>| !all.iter().any(|other| other.is_same(one));
                let group = same_effects.into_iter().filter(is_new).collect();
                self.weigh_too(&mut weighed, group, &[]);
            }
            for other in self.other_robots(likeliest, &known) {
                let group = self.fitted_on(&other, likeliest);
                self.weigh_too(&mut weighed, group, &[]);
            }
        }
        weighed
    }

    /// The most promising of the robots beside the likeliest that are not `known`.
    fn other_robots(&self, likeliest: &Judged<'a>, known: &[Arc<Base<'a>>]) -> Vec<OnOther<'a>> {
        let mut robots = robots_beside(&likeliest.base.morphology);
        robots.retain(|(morphology, lost_links)| {
            let is_it = |base: &Arc<Base<'a>>| {
                base.morphology == *morphology && base.lost_links == *lost_links
            };
            !known.iter().any(is_it)
        });
        self.progress.expect_more(robots.len());
        let single = self.by_single_walk(likeliest).ln_weight;
        let begun = robots
            .into_par_iter()
            .filter_map(|(morphology, lost_links)| {
                let begun = self.begun_beside(likeliest, morphology, lost_links);
                self.progress.advance();
                begun.filter(|one| one.ln_weight > single - HOPELESS)
            });
        let mut begun: Vec<OnOther<'a>> = begun.collect();
        begun.sort_by(|a, b| b.ln_weight.total_cmp(&a.ln_weight));
        begun.truncate(STEPPED);
        self.progress.expect_more(begun.len());
        let stepped = begun.into_par_iter().map(|OnOther { walker, fit, .. }| {
            let (walked, slopes) = (fit.walked, fit.jacobian);
            let fit = walker.advanced(walked, slopes, &likeliest.base.whitening, STEPS);
            self.progress.advance();
            let ln_weight = fit.ln_evidence + self.ln_prior_of(&walker);
            OnOther {
                walker,
                fit,
                ln_weight,
            }
        });
        let mut stepped: Vec<OnOther<'a>> = stepped.collect();
        stepped.retain(|one| one.ln_weight > single - IN_QUESTION);
        stepped.sort_by(|a, b| b.ln_weight.total_cmp(&a.ln_weight));
        stepped.truncate(FITTED);
        stepped
    }

    /// Another robot with what was found of the likeliest, by a single walk. `None` where it does not walk.
    fn begun_beside(
        &self,
        likeliest: &Judged<'a>,
        morphology: Morphology,
        lost_links: LostLinks,
    ) -> Option<OnOther<'a>> {
        let Judged {
            base, walker, fit, ..
        } = likeliest;
        let other = self.setting.walker(Hypothesis {
            effects: self.effects_possible_on(&morphology, likeliest),
            morphology,
            lost_links,
        });
        let walked = other.walk(other.with_parameters_of(walker, &fit.walked.z))?;
        let jacobian = other.with_slopes_of(walker, &fit.jacobian);
        let slopes = base.whitening.apply(&jacobian);
        let linear = Simulated::of(&walked, slopes, &base.whitening);
        let (ln_evidence, _) = linear.with(&[], &other, false).ln_evidence(&base.whitening);
        Some(OnOther {
            ln_weight: ln_evidence + self.ln_prior_of(&other),
            fit: other.integrated(walked, jacobian, &base.whitening),
            walker: other,
        })
    }

    /// Effects of the likeliest hypothesis that another robot may have at the same places.
    fn effects_possible_on(
        &self,
        morphology: &Morphology,
        likeliest: &Judged<'a>,
    ) -> Vec<Placement> {
        let robot = &self.setting.nominal.robot;
        let is_possible =
            |one: &&Placement| one.effect.places(robot, morphology).contains(&one.place);
        let effects = &likeliest.walker.hypothesis.effects;
        effects.iter().filter(is_possible).copied().collect()
    }

    fn ln_prior_of(&self, walker: &Walker<'_>) -> f64 {
        let ln_morphology = (self.known.ln_morphology)(&walker.hypothesis.morphology);
        self.ln_prior(ln_morphology, walker)
    }

    /// Hypotheses on another robot from where that was found: without effects, and with those of the likeliest.
    fn fitted_on(&self, other: &OnOther<'a>, likeliest: &Judged<'a>) -> Vec<Judged<'a>> {
        let (walker, z) = (&other.walker, &other.fit.walked.z);
        let bare = walker.without_effects();
        let ln_prior = (self.known.ln_morphology)(&walker.hypothesis.morphology);
        let begin = bare.with_parameters_of(walker, z);
        let base = Base::at_walk(&bare, self.setting, begin, ln_prior)
            .and_then(|base| base.scattered(self.of_means, self.generator));
        let Some(base) = base.map(Arc::new) else {
            return Vec::new();
        };
        let without = base.fit(&bare);
        let with = self.with_effects_of(likeliest, &base, vec![(walker, z)]);
        let without = self.judge(&base, bare, without);
        std::iter::once(without).chain(with).collect()
    }

    /// The hypothesis that another robot has the effects of the likeliest one: from its own parameters, from those of
    /// the likeliest, and from these. `None` where it cannot have one of them.
    fn with_effects_of(
        &self,
        likeliest: &Judged<'a>,
        base: &Arc<Base<'a>>,
        more: Vec<(&Walker<'a>, &DVector<f64>)>,
    ) -> Option<Judged<'a>> {
        let Judged { walker, fit, .. } = likeliest;
        let z = &fit.walked.z;
        let effects = self.effects_possible_on(&base.morphology, likeliest);
        if effects.is_empty() {
            return None;
        }
        let other = base.with(effects);
        let found = other.with_parameters_of(walker, z);
        let beside_its_own = base.beside_reference(&other, &other.values(&found));
        let more = more
            .into_iter()
            .map(|(known, z)| other.with_parameters_of(known, z));
        let starts = [beside_its_own, found].into_iter().chain(more).collect();
        self.fitted_from(base, other, starts)
    }
}

/// The robots of hypotheses that are weighed, each once.
fn robots_weighed<'a>(all: &[Judged<'a>]) -> Vec<Arc<Base<'a>>> {
    let mut robots: Vec<Arc<Base<'a>>> = Vec::new();
    for one in all.iter().filter(|one| one.is_weighed()) {
        if !robots.iter().any(|base| Arc::ptr_eq(base, &one.base)) {
            robots.push(Arc::clone(&one.base));
        }
    }
    robots
}

/// Robots that differ from this one on one leg at most: in how many of its links are left, and in what became of those
/// that are lost, each both ways.
fn robots_beside(morphology: &Morphology) -> Vec<(Morphology, LostLinks)> {
    let one_leg_changed = (0..morphology.legs()).flat_map(|leg| {
        let other = move |remaining: &usize| *remaining != morphology.remaining(leg);
        let remaining = (0..=morphology.links(leg)).filter(other);
        remaining.map(move |count| morphology.clone().with_remaining(leg, count))
    });
    std::iter::once(morphology.clone())
        .chain(one_leg_changed)
        .flat_map(|one| {
            let states: &[LostLinks] = match one.is_healthy() {
                true => &[LostLinks::Absent],
                false => &[LostLinks::Absent, LostLinks::Locked],
            };
            states.iter().map(move |state| (one.clone(), *state))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use mlr_model::LegLayout;

    use super::*;

    #[test]
    fn robots_beside_one_differ_from_it_on_one_leg_at_most() {
        let layout = LegLayout::new([3; 6]).unwrap();
        let healthy = Morphology::healthy(&layout);
        // Each leg without one, two or three links, gone or locked; and itself.
        assert_eq!(robots_beside(&healthy).len(), 6 * 3 * 2 + 1);
        let lost = healthy.clone().without_leg(2).with_remaining(4, 2);
        let beside = robots_beside(&lost);
        assert_eq!(beside.len(), (1 + 6 * 3) * 2);
        for (other, _) in &beside {
            let differs = |leg: &usize| other.remaining(*leg) != lost.remaining(*leg);
            assert!((0..6).filter(differs).count() <= 1, "{}", other.describe());
        }
        let itself: Vec<LostLinks> = beside
            .iter()
            .filter_map(|(other, state)| (*other == lost).then_some(*state))
            .collect();
        assert_eq!(itself, [LostLinks::Absent, LostLinks::Locked]);
        // Without lost links nothing hangs on.
        let whole = robots_beside(&healthy.clone().without_leg(0));
        let whole = whole.iter().filter(|(other, _)| other.is_healthy());
        assert_eq!(whole.count(), 1);
    }
}
