//! Robots that walk like the log with an effect only, so that nothing is screened on them: those that took the first steps
//! and fell behind, and those of whose damaged legs one is whole. A leg that does not do its part passes for a lost one.

use std::sync::Arc;

use mlr_model::{LostLinks, Morphology};
use nalgebra::DVector;
use rayon::prelude::*;

use super::{
    Judged, Search, Suspect,
    base::Base,
    first_steps::{State, states_of},
    proposals::Screened,
    race::LAST_STEPS,
    screening::placements,
};
use crate::walk::{
    evidence::Fit,
    hypothesis::{Hypothesis, Placement, Walker},
};
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

/// A hypothesis on one of these robots.
struct Candidate<'b, 'a> {
    robot: &'b Unscreened<'b, 'a>,
    walker: Walker<'a>,
    /// As described, with the values of the effect by which a single walk is likeliest.
    z: DVector<f64>,
    /// Logarithm of its weight by that walk.
    ln_promise: f64,
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
        let mut fitted = self.fitted_candidates(&robots, least);
        fitted.sort_by(|(a, ..), (b, ..)| b.total_cmp(a));
        let mut bases: Vec<Arc<Base<'a>>> = Vec::new();
        let mut judged: Vec<Judged<'a>> = Vec::new();
        for (_, robot, walker, fit) in fitted {
            let is_it =
                |base: &&Arc<Base<'a>>| base.is_robot(&robot.suspect.morphology, robot.lost_links);
            let base = match bases.iter().find(is_it) {
                Some(base) => Arc::clone(base),
                None if bases.len() < ROBOTS => {
                    let Some(base) = self.base_of(robot) else {
                        continue;
                    };
                    bases.push(Arc::new(base));
                    Arc::clone(&bases[bases.len() - 1])
                }
                None => continue,
            };
            let walker = base.with(walker.hypothesis.effects);
            let fit = walker.integrated(fit.walked, fit.jacobian, &base.whitening);
            judged.push(self.judge(&base, walker, fit));
        }
        judged
    }

    /// The most promising hypotheses, with the logarithm of the weight that a fit has.
    fn fitted_candidates<'b>(
        &self,
        robots: &'b [Unscreened<'b, 'a>],
        least: f64,
    ) -> Vec<(f64, &'b Unscreened<'b, 'a>, Walker<'a>, Fit)> {
        self.progress.expect_more(robots.len());
        let promising = robots.par_iter().flat_map(|robot| {
            let mut candidates = self.candidates_on(robot);
            candidates.retain(|one| one.ln_promise >= least);
            candidates.truncate(ON_EACH);
            self.progress.advance();
            candidates
        });
        let mut promising: Vec<Candidate<'b, 'a>> = promising.collect();
        promising.sort_by(|a, b| b.ln_promise.total_cmp(&a.ln_promise));
        promising.truncate(MOST);
        self.progress.expect_more(promising.len());
        let fitted = promising.into_par_iter().filter_map(|one| {
            let Candidate {
                robot, walker, z, ..
            } = one;
            let fit = walker.fitted(z, &robot.like.whitening, LAST_STEPS);
            self.progress.advance();
            let fit = fit?;
            let ln_weight = fit.ln_evidence + self.ln_prior(robot.suspect.ln_prior, &walker);
            (ln_weight >= least).then_some((ln_weight, robot, walker, fit))
        });
        fitted.collect()
    }

    /// Every effect that the robot may have, the most promising first.
    fn candidates_on<'b>(&self, robot: &'b Unscreened<'b, 'a>) -> Vec<Candidate<'b, 'a>> {
        let mut placements = placements(self.beginning, &robot.suspect.morphology);
        placements.retain(|placement| robot.at.holds(placement.place));
        let mut candidates: Vec<Candidate<'b, 'a>> = placements
            .into_par_iter()
            .filter_map(|placement| self.likeliest_start(robot, placement))
            .collect();
        candidates.sort_by(|a, b| b.ln_promise.total_cmp(&a.ln_promise));
        candidates
    }

    /// `None` where the robot does not walk with the effect.
    fn likeliest_start<'b>(
        &self,
        robot: &'b Unscreened<'b, 'a>,
        placement: Placement,
    ) -> Option<Candidate<'b, 'a>> {
        let walker = self.beginning.walker(Hypothesis {
            morphology: robot.suspect.morphology.clone(),
            lost_links: robot.lost_links,
            effects: vec![placement],
        });
        let Placement { effect, place } = placement;
        let record = self.beginning.observation.record;
        let starts = effect.starts(place, self.beginning.nominal, record);
        let points = starts.into_iter().map(|values| walker.described(&[values]));
        let (ln_evidence, z) = robot.like.ln_evidence_of_other(&walker, points)?;
        Some(Candidate {
            robot,
            ln_promise: ln_evidence + self.ln_prior(robot.suspect.ln_prior, &walker),
            walker,
            z,
        })
    }

    fn base_of(&self, robot: &Unscreened<'_, 'a>) -> Option<Base<'a>> {
        let Suspect {
            morphology,
            ln_prior,
        } = &robot.suspect;
        Base::as_described(self.beginning, morphology, robot.lost_links, *ln_prior)?
            .scattered(self.beginning_of_means, self.generator)
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
                let on_it = search.candidates_on(robot).into_iter();
                let first = on_it.map(|one| (one.ln_promise, one.walker.hypothesis.effects));
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
