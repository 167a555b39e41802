//! Which robots take the first steps: the whole one, the one identified, and those that promise most by single walks.

use mlr_model::{LostLinks, Morphology};
use rayon::prelude::*;

use super::{Search, Suspect, base::Base};

/// A morphology, and what became of its lost links.
pub(super) type State = (Suspect, LostLinks);

impl<'a> Search<'a, '_> {
    /// These robots after a first step.
    ///
    /// Identification knows no effects and no deviations from the description: an effect may leave the right legs
    /// without a trace among those that it suspects. So every set of lost legs is looked at.
    pub(super) fn first_steps(&self, suspects: &[Suspect]) -> Vec<Base<'a>> {
        let Some(identified) = suspects.first() else {
            return Vec::new();
        };
        let whole = Morphology::healthy(&identified.morphology.layout());
        let mut sure = states_of(self.suspect(whole));
        if !identified.morphology.is_healthy() {
            sure.extend(states_of(identified.clone()));
        }
        if self.effort.bases == 0 {
            return self.after_a_step(&sure);
        }
        let mut others: Vec<State> = Vec::new();
        let lost = sets_of_lost_legs(&identified.morphology).into_iter();
        let lost = lost.map(|morphology| self.suspect(morphology));
        for suspect in suspects.iter().cloned().chain(lost) {
            let is_it = |(other, _): &State| other.morphology == suspect.morphology;
            if suspect.ln_prior.is_finite() && !sure.iter().chain(&others).any(is_it) {
                others.extend(states_of(suspect));
            }
        }
        let mut begun = self.after_a_step(&sure);
        let first = self.by_single_walks(sure, &begun).into_iter().next();
        let others = self.by_single_walks(others, &begun);
        let each = first.iter().chain(&others);
        let best = each.map(|(ln_promise, _)| *ln_promise);
        let least = best.fold(f64::NEG_INFINITY, f64::max) - self.hopeless();
        let promising = most_promising(others, least, self.effort.bases);
        begun.extend(self.after_a_step(&promising));
        begun
    }

    pub(super) fn suspect(&self, morphology: Morphology) -> Suspect {
        Suspect {
            ln_prior: (self.known.ln_morphology)(&morphology),
            morphology,
        }
    }

    fn after_a_step(&self, states: &[State]) -> Vec<Base<'a>> {
        self.progress.expect_more(states.len());
        let begun = states.par_iter().filter_map(|(suspect, lost_links)| {
            let Suspect {
                morphology,
                ln_prior,
            } = suspect;
            let base = Base::new(self.beginning, morphology, *lost_links, *ln_prior);
            self.progress.advance();
            base
        });
        begun.collect()
    }

    /// What each of these promises by single walks, the most promising first: each is as sensitive to its parameters, and
    /// errs as much, as the `known` robot that is most like it.
    fn by_single_walks(&self, states: Vec<State>, known: &[Base<'a>]) -> Vec<(f64, State)> {
        self.progress.expect_more(states.len());
        let weighed = states.into_par_iter().filter_map(|state| {
            let ln_promise = self.ln_promise_by_single_walks(&state, known);
            self.progress.advance();
            Some((ln_promise?, state))
        });
        let mut ranked: Vec<(f64, State)> = weighed.collect();
        ranked.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        ranked
    }

    fn ln_promise_by_single_walks(&self, state: &State, known: &[Base<'a>]) -> Option<f64> {
        let (suspect, lost_links) = state;
        let unlike = |base: &&Base<'a>| {
            let (own, others) = (
                suspect.morphology.damaged_legs(),
                base.morphology.damaged_legs(),
            );
            let missing = others.iter().filter(|leg| !own.contains(leg)).count();
            let additional = own.iter().filter(|leg| !others.contains(leg)).count();
            (missing + additional, base.lost_links != *lost_links)
        };
        let Some(like) = known.iter().min_by_key(unlike) else {
            return Some(0.0);
        };
        let walker = self.beginning.bare(&suspect.morphology, *lost_links);
        let found = walker.with_parameters_of(&like.with(Vec::new()), &like.reference.z);
        let starts = [walker.described(&[]), found];
        let promise = self.promise(like, suspect.ln_prior, walker, starts)?;
        Some(promise.ln_weight)
    }
}

/// The first of these in the order of what they promise, as far as that is at least `least`. As many as settle, and
/// three times as many with other damaged legs each: else the links of the same legs leave no place to others, which may
/// be the right ones with an effect.
fn most_promising(ranked: Vec<(f64, State)>, least: f64, settle: usize) -> Vec<State> {
    let may_win = |(ln_promise, _): &(f64, State)| *ln_promise >= least;
    let mut chosen: Vec<State> = Vec::new();
    for (_, state) in ranked.into_iter().filter(may_win) {
        let damaged = state.0.morphology.damaged_legs();
        let are_known = |(other, _): &State| other.morphology.damaged_legs() == damaged;
        let has_place = chosen.len() < 4 * settle;
        if chosen.len() < settle || (has_place && !chosen.iter().any(are_known)) {
            chosen.push(state);
        }
    }
    chosen
}

/// Lost links gone, and locked, if there are any.
pub(super) fn states_of(suspect: Suspect) -> Vec<State> {
    match suspect.morphology.is_healthy() {
        true => vec![(suspect, LostLinks::Absent)],
        false => vec![
            (suspect.clone(), LostLinks::Absent),
            (suspect, LostLinks::Locked),
        ],
    }
}

/// Robots like this one that have lost any legs, up to half of them.
fn sets_of_lost_legs(robot: &Morphology) -> Vec<Morphology> {
    let mut sets = vec![Morphology::healthy(&robot.layout())];
    for leg in 0..robot.legs() {
        for index in 0..sets.len() {
            if sets[index].damaged_legs().len() < robot.legs() / 2 {
                sets.push(sets[index].clone().without_leg(leg));
            }
        }
    }
    sets.retain(|one| !one.is_healthy());
    sets
}

#[cfg(test)]
mod tests {
    use mlr_model::{Gait, LegLayout, Robot, SimulationSettings};

    use super::*;
    use crate::{
        walk::{
            WalkModel,
            search::tests::{record_of, with_search},
        },
        walk_effects::{Place, find},
    };

    #[test]
    fn lost_legs_that_nobody_suspects_take_the_first_steps() {
        let robot = Robot::jethexa();
        let nominal = WalkModel::nominal(robot, Gait::tripod(), SimulationSettings::default());
        let whole = Morphology::healthy(&nominal.robot.layout());
        let lost = [0, 1, 2]
            .into_iter()
            .fold(whole.clone(), Morphology::without_leg);
        let mut stuck = nominal.clone();
        find("stuck_joint")
            .unwrap()
            .apply(Place::Link(4, 1), &[0.2], &mut stuck);
        let record = record_of(&stuck, &lost);
        with_search(&record, &nominal, |search| {
            let suspects = [search.suspect(whole.without_leg(1))];
            let begun = search.first_steps(&suspects);
            let weight = |legs: &[usize]| {
                let on_them = begun
                    .iter()
                    .filter(|base| base.morphology.damaged_legs() == legs);
                on_them
                    .map(|base| search.ln_weight_of(base))
                    .fold(f64::NEG_INFINITY, f64::max)
            };
            let (right, suspected) = (weight(&[1, 2, 3]), weight(&[2]));
            assert!(suspected.is_finite());
            assert!(right > suspected + 10.0, "{right} {suspected}");
        });
    }

    #[test]
    fn others_than_the_likeliest_have_their_places_as_far_as_they_may_win() {
        let whole = Morphology::healthy(&LegLayout::new(vec![3; 6]).unwrap());
        let suspect = |morphology| Suspect {
            morphology,
            ln_prior: 0.0,
        };
        let sets = sets_of_lost_legs(&whole).into_iter();
        let ranked: Vec<(f64, State)> = sets
            .flat_map(|lost| states_of(suspect(lost)))
            .enumerate()
            .map(|(k, state)| (-(k as f64), state))
            .collect();
        let settle = 3;
        let legs = |least: f64| {
            let chosen = most_promising(ranked.clone(), least, settle).into_iter();
            let mut legs: Vec<Vec<usize>> = chosen
                .map(|(suspect, _)| suspect.morphology.damaged_legs())
                .collect();
            legs.dedup();
            legs
        };
        assert!(legs(-30.0).len() > 2 * settle, "{:?}", legs(-30.0));
        // Each set is there twice, gone and locked.
        assert_eq!(legs(-3.0).len(), 2);
        assert!(legs(1.0).is_empty());
    }

    #[test]
    fn every_set_of_up_to_half_of_the_legs_is_there_once() {
        for (legs, sets) in [(4, 4 + 6), (6, 6 + 15 + 20), (8, 8 + 28 + 56 + 70)] {
            let layout = LegLayout::new(vec![3; legs]).unwrap();
            let mut lost: Vec<Vec<usize>> = sets_of_lost_legs(&Morphology::healthy(&layout))
                .iter()
                .map(Morphology::damaged_legs)
                .collect();
            assert!(
                lost.iter()
                    .all(|set| !set.is_empty() && set.len() <= legs / 2)
            );
            lost.sort();
            lost.dedup();
            assert_eq!(lost.len(), sets);
        }
    }
}
