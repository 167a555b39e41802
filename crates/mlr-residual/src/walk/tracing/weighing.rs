//! Which morphology suits the record, given effects.

use std::sync::Arc;

use mlr_model::{LostLinks, Morphology};
use rayon::prelude::*;

use super::{
    Suspect, Tracing,
    state::{Hypotheses, State},
};
use crate::walk::{Calibration, Effort, Placed, Start, WalkError};

/// Robots that are calibrated in full after a first look at all.
const FINALISTS: usize = 6;
/// Of these, those that may have the same damaged legs.
const FINALISTS_ALIKE: usize = 3;
/// How much less probable a morphology may be after the first look, in the units of cost.
const WITHIN: f64 = 25.0;
/// The same for lost links gone or locked, where only one morphology is looked at.
const WITHIN_OF_ONE: f64 = 40.0;
/// How much more than a robot that is known one may cost at a first look to be calibrated at all.
const HOPELESS: f64 = 150.0;
/// How much more than the best a robot may cost after a first calibration to be calibrated
/// further: polls gain 17 at most on robots that nearly tip over.
const WORTH_MORE: f64 = 20.0;
/// How much less probable other links of the same damaged legs may be for effects to be tried
/// on them: without its effect the right robot may do far worse than one with other links.
const WITHIN_OF_LINKS: f64 = 40.0;
/// Other robots that effects are tried on.
const MOST_BESIDE: usize = 5;

impl<'a> Tracing<'a> {
    /// The likeliest of the suspects, unless it has other damaged legs and is hardly likelier
    /// than the first of those that are `known`; with it the others that are hardly less likely.
    pub(super) fn weighed(
        &self,
        known: Vec<State<'a>>,
        suspects: &[Suspect],
        effects: &[Placed],
    ) -> Result<Option<Hypotheses<'a>>, WalkError> {
        let others: Vec<Suspect> = suspects
            .iter()
            .filter(|suspect| {
                let is_known = |known: &State<'_>| known.morphology == suspect.morphology;
                !known.iter().any(is_known)
            })
            .cloned()
            .collect();
        let mut states = known;
        if !others.is_empty() {
            let ranked = self.ranked(&others, effects, states.first())?;
            states.extend(ranked);
        }
        let mut states = states.into_iter().map(Arc::new);
        let Some(mut held) = states.next() else {
            return Ok(None);
        };
        let mut beside: Vec<Arc<State<'a>>> = states.collect();
        beside.sort_by(|a, b| a.total.total_cmp(&b.total));
        let switch_gain = self.settings.switch_gain;
        // Which links of the damaged legs are gone is a lesser question than which legs.
        let needed = |other: &State<'_>| match other.has_same_legs(&held) {
            true => 0.0,
            false => switch_gain,
        };
        let better = beside
            .iter()
            .position(|other| other.total < held.total - needed(other));
        if let Some(better) = better {
            std::mem::swap(&mut beside[better], &mut held);
        }
        let within = |other: &State<'_>| match other.has_same_legs(&held) {
            true => WITHIN_OF_LINKS,
            false => switch_gain / 2.0,
        };
        beside.retain(|other| other.total < held.total + within(other));
        beside.truncate(MOST_BESIDE);
        Ok(Some(Hypotheses { held, beside }))
    }

    /// The best few suspects calibrated with these effects, lost links gone or locked, the
    /// likeliest first. None of them looks hopeless beside the robot that is `known`, if any.
    pub(super) fn ranked(
        &self,
        suspects: &[Suspect],
        effects: &[Placed],
        known: Option<&State<'a>>,
    ) -> Result<Vec<State<'a>>, WalkError> {
        let cases: Vec<(&Suspect, LostLinks)> = suspects
            .iter()
            .flat_map(|suspect| {
                let cases: &[LostLinks] = if suspect.morphology.is_healthy() {
                    &[LostLinks::Absent]
                } else {
                    &[LostLinks::Absent, LostLinks::Locked]
                };
                cases.iter().map(move |lost_links| (suspect, *lost_links))
            })
            .collect();
        let within = match suspects {
            [_] => WITHIN_OF_ONE,
            _ => WITHIN,
        };
        let finalists = self.finalists(cases, effects, within, known)?;
        self.progress.expect_more(2 * finalists.len());
        let states = finalists
            .into_par_iter()
            .map(|(suspect, lost_links)| {
                let start = Start::described(self.with_lost(lost_links));
                let state = self.calibrated_from(&start, suspect, effects, Effort::Slopes);
                self.progress.advance();
                state
            })
            .collect::<Result<Vec<_>, WalkError>>()?;
        let states: Vec<State<'a>> = states.into_iter().flatten().collect();
        let best = states.iter().map(|state| state.total);
        let most = best.fold(f64::INFINITY, f64::min) + WORTH_MORE;
        let further = states.into_par_iter().map(|state| {
            let state = match state.total <= most {
                true => self.calibrated_further(state),
                false => Ok(state),
            };
            self.progress.advance();
            state
        });
        let mut states = further.collect::<Result<Vec<_>, WalkError>>()?;
        states.sort_by(|a, b| a.total.total_cmp(&b.total));
        Ok(states)
    }

    /// Looks at all cases and chooses the best few, none of which costs more than the best
    /// and `within`.
    fn finalists<'s>(
        &self,
        cases: Vec<(&'s Suspect, LostLinks)>,
        effects: &[Placed],
        within: f64,
        known: Option<&State<'a>>,
    ) -> Result<Vec<(&'s Suspect, LostLinks)>, WalkError> {
        self.progress.expect_more(cases.len());
        let glance = |suspect: &Suspect, lost_links| -> Result<Option<f64>, WalkError> {
            let cost = Calibration::glance(
                &self.settings.comparison,
                &self.with_lost(lost_links),
                effects,
                &suspect.morphology,
                self.record,
            )?;
            Ok(cost.map(|cost| cost - 2.0 * suspect.ln_prior))
        };
        let mut glances = cases
            .into_par_iter()
            .map(|(suspect, lost_links)| {
                let cost = glance(suspect, lost_links)?;
                self.progress.advance();
                Ok(cost.map(|cost| (cost, suspect, lost_links)))
            })
            .collect::<Result<Vec<_>, WalkError>>()?
            .into_iter()
            .flatten()
            .collect::<Vec<_>>();
        glances.sort_by(|(a, ..), (b, ..)| a.total_cmp(b));
        let best = glances.first().map_or(0.0, |(cost, ..)| *cost);
        let known = match known {
            Some(known) => glance(&known.suspect(), known.lost_links())?,
            None => None,
        };
        let most = known.map_or(f64::INFINITY, |known| known + HOPELESS);
        glances.retain(|(cost, ..)| *cost <= most.min(best + within));
        let mut chosen: Vec<(&'s Suspect, LostLinks)> = Vec::new();
        for (_, suspect, lost_links) in glances {
            let legs = suspect.morphology.damaged_legs();
            let has_same_legs =
                |(other, _): &&(&Suspect, LostLinks)| other.morphology.damaged_legs() == legs;
            let alike = chosen.iter().filter(has_same_legs).count();
            if chosen.len() < FINALISTS && alike < FINALISTS_ALIKE {
                chosen.push((suspect, lost_links));
            }
        }
        Ok(chosen)
    }

    /// The morphologies that differ in one leg.
    pub(super) fn neighbours(&self, morphology: &Morphology) -> Vec<Suspect> {
        (0..morphology.legs())
            .flat_map(|leg| (0..=morphology.links(leg)).map(move |remaining| (leg, remaining)))
            .map(|(leg, remaining)| morphology.clone().with_remaining(leg, remaining))
            .map(|neighbour| self.suspect(neighbour))
            .collect()
    }
}
