//! Robots that walk like the log with an effect only, so that nothing is screened on them: those that took the first steps
//! and fell behind, and those of whose damaged legs one is whole. A leg that does not do its part passes for a lost one.

use std::sync::Arc;

use mlr_model::{LostLinks, Morphology};
use rayon::prelude::*;

use super::{
    Judged, Search, Suspect,
    base::Base,
    first_steps::{State, states_of},
    promise::{Kept, Promise, sort_promises},
    proposals::Screened,
    race::LAST_STEPS,
    screening::placements,
};
use crate::walk::hypothesis::{Hypothesis, Placement};
use crate::walk_effects::Place;

/// Hypotheses that are fitted, and of each robot.
const MOST: usize = 8;
const ON_EACH: usize = 2;
/// Robots whose hypotheses take part in the race.
const ROBOTS: usize = 3;

/// A robot that may have an effect.
struct Unscreened<'b, 'a> {
    /// It is as sensitive to what robots of one make differ by as this one, and errs as much.
    like: &'b Base<'a>,
    suspect: Suspect,
    lost_links: LostLinks,
    /// Where the effect is: without one on a restored leg, this is another robot.
    at: Part,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    /// A leg, counted from 1.
    Leg(usize),
    /// What concerns the robot, its ground or its sensor as a whole.
    Robot,
}

impl<'a> Search<'a, '_> {
    /// Hypotheses on robots on which no effect is `screened`, fitted, as far as they may still win against `best`, the
    /// logarithm of the weight of the most promising effect so far. `begun` are the robots that took the first steps, the
    /// likeliest first: of those with the same damaged legs the first counts, as far as it is not hopeless.
    ///
    /// Each effect is walked once from each start on the robot as described, and the likeliest are fitted by sensitivities
    /// of their own: without the effect, such a robot walks unlike the log, and its sensitivities there say little of how it
    /// walks with it.
    pub(super) fn on_unscreened_robots(
        &self,
        begun: &[Base<'a>],
        screened: &[Screened<'a>],
        best: f64,
    ) -> Vec<Judged<'a>> {
        let least = best - self.hopeless();
        let robots = self.unscreened(begun, screened);
        self.progress.expect_more(robots.len());
        let promises = robots.par_iter().flat_map(|robot| {
            let mut on_it = self.promises_on(robot);
            on_it.retain(|one| one.ln_weight >= least);
            on_it.truncate(ON_EACH);
            self.progress.advance();
            on_it
        });
        let mut kept = self.kept(promises.collect(), MOST, LAST_STEPS);
        kept.retain(|one| one.ln_weight >= least);
        let mut bases: Vec<Arc<Base<'a>>> = Vec::new();
        let mut judged: Vec<Judged<'a>> = Vec::new();
        for Kept {
            ln_robot,
            walker,
            fit,
            ..
        } in kept
        {
            let Hypothesis {
                morphology,
                lost_links,
                effects,
            } = walker.hypothesis;
            let is_it = |base: &&Arc<Base<'a>>| base.is_robot(&morphology, lost_links);
            let base = match bases.iter().find(is_it) {
                Some(base) => Arc::clone(base),
                None if bases.len() < ROBOTS => {
                    let Some(base) = self.scattered_base(&morphology, lost_links, ln_robot) else {
                        continue;
                    };
                    bases.push(Arc::new(base));
                    Arc::clone(&bases[bases.len() - 1])
                }
                None => continue,
            };
            let walker = base.with(effects);
            let fit = walker.integrated(fit.walked, fit.jacobian, &base.whitening);
            judged.push(self.judge(&base, walker, fit));
        }
        judged
    }

    /// A robot as described, with errors of walks that scatter as its own.
    fn scattered_base(
        &self,
        morphology: &Morphology,
        lost_links: LostLinks,
        ln_prior: f64,
    ) -> Option<Base<'a>> {
        Base::as_described(self.beginning, morphology, lost_links, ln_prior)?
            .scattered(self.beginning_of_means, self.generator)
    }

    /// Every effect that the robot may have, the most promising first.
    fn promises_on<'b>(&self, robot: &Unscreened<'b, 'a>) -> Vec<Promise<'b, 'a>> {
        let mut placements = placements(self.beginning, &robot.suspect.morphology);
        placements.retain(|placement| robot.at.holds(placement.place));
        let promises = placements
            .into_par_iter()
            .filter_map(|placement| self.promise_of_starts(robot, placement));
        let mut promises: Vec<Promise<'b, 'a>> = promises.collect();
        sort_promises(&mut promises);
        promises
    }

    /// What an effect promises from the likeliest of its starts, the robot as described. `None` where it does not walk.
    fn promise_of_starts<'b>(
        &self,
        robot: &Unscreened<'b, 'a>,
        placement: Placement,
    ) -> Option<Promise<'b, 'a>> {
        let walker = self.beginning.walker(Hypothesis {
            morphology: robot.suspect.morphology.clone(),
            lost_links: robot.lost_links,
            effects: vec![placement],
        });
        let Placement { effect, place } = placement;
        let record = self.beginning.observation.record;
        let starts = effect
            .starts(place, self.beginning.nominal, record)
            .into_iter();
        let points: Vec<_> = starts.map(|values| walker.described(&[values])).collect();
        self.promise(robot.like, robot.suspect.ln_prior, walker, points)
    }

    fn unscreened<'b>(
        &self,
        begun: &'b [Base<'a>],
        screened: &[Screened<'a>],
    ) -> Vec<Unscreened<'b, 'a>> {
        let is_screened = |(suspect, lost_links): &State| {
            let mut robots = screened.iter().map(|on| &on.base);
            robots.any(|base| base.is_robot(&suspect.morphology, *lost_links))
        };
        let weight = |base: &Base<'a>| self.ln_weight_of(base);
        let least = begun.first().map_or(0.0, weight) - self.hopeless();
        let mut wanted: Vec<Unscreened<'b, 'a>> = Vec::new();
        let mut seen: Vec<Vec<usize>> = Vec::new();
        for like in begun.iter().filter(|base| weight(base) >= least) {
            let damaged = like.morphology.damaged_legs();
            if seen.contains(&damaged) {
                continue;
            }
            let own = (self.suspect(like.morphology.clone()), like.lost_links);
            let legs_are_screened = screened
                .iter()
                .any(|on| on.base.morphology.damaged_legs() == damaged);
            let own = (!legs_are_screened).then_some((own, Part::Robot));
            let restored = damaged.iter().flat_map(|leg| {
                let states = self.with_leg_restored(like, leg - 1).into_iter();
                states.map(|state| (state, Part::Leg(*leg)))
            });
            for (state, at) in own.into_iter().chain(restored) {
                let is_known = wanted.iter().any(|one| {
                    let (suspect, lost_links) = &state;
                    one.at == at
                        && one.suspect.morphology == suspect.morphology
                        && one.lost_links == *lost_links
                });
                if !is_screened(&state) && !is_known {
                    let (suspect, lost_links) = state;
                    wanted.push(Unscreened {
                        like,
                        suspect,
                        lost_links,
                        at,
                    });
                }
            }
            seen.push(damaged);
        }
        wanted
    }

    /// The robot with this leg, from 0, whole: its other damaged legs as they were taken to be, and lost whole, gone and
    /// locked. What was found of them beside a leg that is not lost says little of how much of them is left.
    fn with_leg_restored(&self, taken_for: &Base<'a>, leg: usize) -> Vec<State> {
        let as_taken = with_leg_restored(&taken_for.morphology, leg);
        let damaged = as_taken.damaged_legs().into_iter();
        let without_them = damaged.fold(as_taken.clone(), |robot, leg| robot.without_leg(leg - 1));
        let mut states = states_of(self.suspect(without_them));
        if !as_taken.is_healthy() {
            states.push((self.suspect(as_taken), taken_for.lost_links));
        }
        states
    }
}

impl Part {
    fn holds(self, place: Place) -> bool {
        match self {
            Self::Leg(leg) => place.leg() == leg,
            Self::Robot => place == Place::Robot,
        }
    }
}

/// The same robot with this leg, from 0, whole.
pub(super) fn with_leg_restored(robot: &Morphology, leg: usize) -> Morphology {
    robot.clone().with_remaining(leg, robot.links(leg))
}

#[cfg(test)]
mod tests {
    use mlr_model::{Gait, Robot, SimulationSettings};

    use super::*;
    use crate::walk::{
        WalkModel,
        search::tests::{record_of, with_search},
    };
    use crate::walk_effects::find;

    /// A leg that is too short does not stand where it should, and passes for one that lacks its last link.
    #[test]
    fn a_short_link_beside_a_lost_leg_is_found_where_both_legs_pass_for_damaged() {
        let robot = Robot::jethexa();
        let nominal = WalkModel::nominal(robot, Gait::tripod(), SimulationSettings::default());
        let whole = Morphology::healthy(&nominal.robot.layout());
        let lost = whole.clone().without_leg(5);
        let short = Placement {
            effect: find("short_link").unwrap(),
            place: Place::Link(2, 2),
        };
        let mut model = nominal.clone();
        model.simulation.lost_links = LostLinks::Locked;
        short.effect.apply(short.place, &[0.034], &mut model);
        let record = record_of(&model, &lost);
        with_search(&record, &nominal, |search| {
            let taken_for = lost.clone().with_remaining(2, 2).with_remaining(5, 1);
            let taken_for =
                Base::new(search.beginning, &taken_for, LostLinks::Absent, 0.0).unwrap();
            let begun = [taken_for];
            let robots = search.unscreened(&begun, &[]);
            let likeliest = |robot: &Unscreened<'_, '_>| {
                let on_it = search.promises_on(robot).into_iter();
                let first = on_it.map(|one| (one.ln_weight, one.walker.hypothesis.effects));
                first.max_by(|a, b| a.0.total_cmp(&b.0))
            };
            let on = |morphology: &Morphology, lost_links, leg| {
                let robot = robots.iter().find(|one| {
                    one.suspect.morphology == *morphology
                        && one.lost_links == lost_links
                        && one.at == Part::Leg(leg)
                });
                likeliest(robot.unwrap()).unwrap()
            };
            let (promise, effects) = on(&lost, LostLinks::Locked, 3);
            assert_eq!(effects, [short]);
            // The control: the other leg restored.
            let (of_other, _) = on(&whole.without_leg(2), LostLinks::Locked, 6);
            assert!(promise > of_other + 10.0, "{promise} {of_other}");
        });
    }

    #[test]
    fn of_robots_that_fell_behind_only_what_concerns_all_of_them_is_looked_at() {
        let at = |part: Part, place| part.holds(place);
        assert!(at(Part::Robot, Place::Robot) && !at(Part::Robot, Place::Leg(0)));
        assert!(at(Part::Leg(1), Place::Link(0, 2)) && !at(Part::Leg(1), Place::Robot));
    }
}
