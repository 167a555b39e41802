//! The effects of the likeliest hypothesis on robots that have lost one leg more than its own, or one less.

use std::sync::Arc;

use mlr_model::Morphology;
use rayon::prelude::*;

use super::{
    Judged, Search,
    base::Base,
    first_steps::{State, states_of},
    other_robots::robots_weighed,
    promise::{Kept, Promise},
    unscreened::with_leg_restored,
    weighing::Weighed,
};
use crate::walk::hypothesis::Hypothesis;

/// Robots that are fitted, of those that promise most by single walks.
const FITTED: usize = 3;
/// Steps of such a fit, at most.
const STEPS: usize = 3;

impl<'a> Search<'a, '_> {
    /// These hypotheses, and the effects of the likeliest one on the robot that they fit best, of those that differ from its
    /// own in one leg.
    ///
    /// A robot that lacks a leg and has an effect may walk unlike all that lack legs only, so that without the effect it
    /// was never among the likeliest.
    pub(super) fn with_effects_on_robots_alike(&self, mut weighed: Weighed<'a>) -> Weighed<'a> {
        let all = weighed.all();
        let Some(likeliest) = all.iter().find(|one| one.is_weighed()) else {
            return weighed;
        };
        if likeliest.hypothesis().is_bare() {
            return weighed;
        }
        let weighed_robots = robots_weighed(&all);
        let is_weighed = |(suspect, lost_links): &State| {
            let mut robots = weighed_robots.iter();
            robots.any(|base| base.is_robot(&suspect.morphology, *lost_links))
        };
        let states: Vec<State> = alike(&likeliest.base.morphology)
            .into_iter()
            .flat_map(|morphology| states_of(self.suspect(morphology)))
            .filter(|state| state.0.ln_prior.is_finite() && !is_weighed(state))
            .collect();
        self.progress.expect_more(states.len());
        let promises = states.into_par_iter().filter_map(|state| {
            let promise = self.promise_with_effects_of(likeliest, &state);
            self.progress.advance();
            promise
        });
        // A single walk with the parameters of another robot says little of how well a robot fits.
        let kept = self.kept(promises.collect(), FITTED, STEPS);
        let Some(best) = kept.first() else {
            return weighed;
        };
        let own = (
            self.suspect(likeliest.base.morphology.clone()),
            likeliest.base.lost_links,
        );
        let own = self.promise_with_effects_of(likeliest, &own);
        let least = own.map_or(f64::NEG_INFINITY, |own| own.ln_weight) - self.in_question();
        if best.ln_weight > least {
            self.progress.expect_more(1);
            let with = self.with_and_without_effects(best);
            self.progress.advance();
            self.weigh_too(&mut weighed, with, &[]);
        }
        weighed
    }

    /// What a robot promises with the effects of the likeliest hypothesis, with the parameters of that and as described.
    /// `None` where it cannot have these effects, or does not walk.
    fn promise_with_effects_of<'b>(
        &self,
        likeliest: &'b Judged<'a>,
        state: &State,
    ) -> Option<Promise<'b, 'a>> {
        let (suspect, lost_links) = state;
        let effects = &likeliest.hypothesis().effects;
        if !self.may_have(&suspect.morphology, effects) {
            return None;
        }
        let walker = self.setting.walker(Hypothesis {
            morphology: suspect.morphology.clone(),
            lost_links: *lost_links,
            effects: effects.clone(),
        });
        let z = &likeliest.fit.walked.z;
        let values = likeliest.walker.values(z);
        let points = [
            walker.with_parameters_of(&likeliest.walker, z),
            walker.described(&values),
        ];
        self.promise(&likeliest.base, suspect.ln_prior, walker, points)
    }

    /// That robot without the effects and with them.
    fn with_and_without_effects(&self, alike: &Kept<'a>) -> Vec<Judged<'a>> {
        let Kept {
            ln_robot,
            walker: known,
            fit,
            ..
        } = alike;
        let Hypothesis {
            morphology,
            lost_links,
            ..
        } = &known.hypothesis;
        let bare = self.setting.bare(morphology, *lost_links);
        let z = bare.with_parameters_of(known, &fit.walked.z);
        let base = Base::at_walk(&bare, self.setting, z, *ln_robot)
            .and_then(|base| base.scattered(self.of_means, self.generator));
        let Some(base) = base.map(Arc::new) else {
            return Vec::new();
        };
        let of_base = base.fit(&bare);
        let mut fitted = vec![self.judge(&base, bare, of_base)];
        fitted.extend(self.with_effects_of(known, fit, &base));
        fitted
    }
}

/// Robots that lack one leg more than this one, or of whose damaged legs one is whole.
fn alike(robot: &Morphology) -> Vec<Morphology> {
    let damaged = robot.damaged_legs();
    let with_other_leg = |leg: usize| match damaged.contains(&(leg + 1)) {
        true => with_leg_restored(robot, leg),
        false => robot.clone().without_leg(leg),
    };
    (0..robot.legs()).map(with_other_leg).collect()
}

#[cfg(test)]
mod tests {
    use mlr_model::LegLayout;

    use super::*;

    #[test]
    fn robots_alike_lack_one_leg_more_or_one_less() {
        let layout = LegLayout::new(vec![3; 6]).unwrap();
        let robot = Morphology::parse_legs_lost("4", &layout).unwrap();
        let legs: Vec<Vec<usize>> = alike(&robot).iter().map(Morphology::damaged_legs).collect();
        let expected: [&[usize]; 6] = [&[1, 4], &[2, 4], &[3, 4], &[], &[4, 5], &[4, 6]];
        assert_eq!(legs, expected);
    }
}
