//! Where the tracing has come to, and which morphology suits it.

use std::{collections::BTreeMap, sync::Arc};

use mlr_model::{LostLinks, Morphology};
use rayon::prelude::*;

use super::{Suspect, Tracing, errors};
use crate::walk::{
    Calibration, Comparison, Effort, Placed, Start, StretchErrors, Trial, WalkError, WalkModel,
    Walker, comparison::is_rough, usual::Difference,
};

/// Robots that are calibrated in full after a first look at all.
const FINALISTS: usize = 6;
/// Of these, those that may have the same damaged legs.
const FINALISTS_ALIKE: usize = 3;
/// How much more than the best a robot may cost after a first calibration to be calibrated
/// further: polls gain 17 at most on robots that nearly tip over.
const WORTH_MORE: f64 = 20.0;
/// How much more than a robot that is known one may cost at a first look: calibration makes up
/// for less than that.
const HOPELESS: f64 = 150.0;
/// How much less probable a morphology may be after the first look, in the units of cost.
const WITHIN: f64 = 25.0;
/// The same for lost links gone or locked, where only one morphology is looked at.
const WITHIN_OF_ONE: f64 = 40.0;
/// How much less probable other links of the same damaged legs may be for effects to be tried
/// on them: without its effect the right robot may do far worse than one with other links.
const WITHIN_OF_LINKS: f64 = 40.0;
/// Other robots that effects are tried on.
const MOST_BESIDE: usize = 5;
/// Usual differences of the body in a model that cost less than this leave room for effects.
const WORTH_UNDOING: f64 = 2.0;

/// Where the tracing has come to: a morphology, its calibrated model, and the effects
/// found.
#[derive(Clone)]
pub(super) struct State<'a> {
    pub(super) morphology: Morphology,
    pub(super) calibration_model: WalkModel,
    pub(super) comparison: Comparison<'a>,
    pub(super) trial: Trial,
    pub(super) ln_prior: f64,
    /// Cost on both stretches, with prior.
    pub(super) total: f64,
}

impl State<'_> {
    pub(super) fn lost_links(&self) -> LostLinks {
        self.calibration_model.simulation.lost_links
    }

    /// Whether the same legs are damaged, whichever of their links are left.
    pub(super) fn has_same_legs(&self, other: &State<'_>) -> bool {
        self.morphology.damaged_legs() == other.morphology.damaged_legs()
    }

    fn is_rough(&self) -> bool {
        is_rough(self.trial.fit_deg2)
    }

    pub(super) fn walker(&self) -> Walker<'_> {
        Walker {
            model: &self.calibration_model,
            morphology: &self.morphology,
            body: None,
        }
    }

    /// The calibrated model with the effects found.
    pub(super) fn model(&self) -> WalkModel {
        self.walker().with(&self.trial.effects)
    }

    pub(super) fn suspect(&self) -> Suspect {
        Suspect {
            morphology: self.morphology.clone(),
            ln_prior: self.ln_prior,
        }
    }

    /// Its calibration, for another one to begin with.
    pub(super) fn start(&self) -> Start {
        Start {
            model: self.calibration_model.clone(),
            there: self.comparison.there.clone(),
        }
    }

    pub(super) fn usual_differences(&self) -> BTreeMap<String, f64> {
        let there = self.comparison.there.iter().zip(&self.trial.usual);
        Difference::ALL
            .into_iter()
            .zip(there)
            .filter(|(difference, _)| !difference.is_of_zeros())
            .map(|(difference, (there, more))| (difference.name().to_string(), there + more))
            .collect()
    }
}

/// The robot as it is held to be, and others that it may be as well.
pub(super) struct Hypotheses<'a> {
    pub(super) held: Arc<State<'a>>,
    /// Hardly less likely, or other links of the same legs, the likeliest first.
    pub(super) beside: Vec<Arc<State<'a>>>,
}

impl<'a> Tracing<'a> {
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

    /// A morphology, with what is known of it beside the record.
    pub(super) fn suspect(&self, morphology: Morphology) -> Suspect {
        Suspect {
            ln_prior: self.search.ln_prior(&morphology),
            morphology,
        }
    }

    /// The morphologies that differ in one leg.
    pub(super) fn neighbours(&self, morphology: &Morphology) -> Vec<Suspect> {
        (0..morphology.legs())
            .flat_map(|leg| (0..=morphology.links(leg)).map(move |remaining| (leg, remaining)))
            .map(|(leg, remaining)| morphology.clone().with_remaining(leg, remaining))
            .map(|neighbour| self.suspect(neighbour))
            .collect()
    }

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

    /// The same robot as described, with the same effects: none of what is usual is in its
    /// model. `None` where there is hardly anything in it, or the walk diverges.
    pub(super) fn uncalibrated(&self, state: &State<'a>) -> Result<Option<State<'a>>, WalkError> {
        let in_body: f64 = Difference::ALL
            .into_iter()
            .zip(&state.comparison.there)
            .filter(|(difference, _)| difference.is_of_body())
            .map(|(_, size)| size * size)
            .sum();
        if in_body < WORTH_UNDOING {
            return Ok(None);
        }
        let model = self.with_lost(state.lost_links());
        let settings = &self.settings.comparison;
        let effects = &state.trial.effects;
        let with_effects = Walker {
            model: &model,
            morphology: &state.morphology,
            body: None,
        }
        .with(effects);
        let comparison =
            Calibration::uncalibrated(settings, &with_effects, &state.morphology, self.record)?;
        Ok(comparison.map(|comparison| State {
            calibration_model: model,
            comparison,
            ..state.clone()
        }))
    }

    /// The state that a trial of this suspect stands for.
    pub(super) fn with_trial(
        &self,
        state: &State<'a>,
        suspect: &Suspect,
        trial: &Trial,
    ) -> State<'a> {
        let unseen = state.comparison.cost_of(trial.unseen_deg2);
        State {
            total: trial.cost + unseen - 2.0 * suspect.ln_prior,
            trial: trial.clone(),
            morphology: suspect.morphology.clone(),
            ln_prior: suspect.ln_prior,
            ..state.clone()
        }
    }

    pub(super) fn with_lost(&self, lost_links: LostLinks) -> WalkModel {
        let mut model = self.nominal.clone();
        model.simulation.lost_links = lost_links;
        model
    }

    /// Calibrates a suspect's model and fits its effects in turn, because either depends
    /// on the other.
    pub(super) fn calibrated(
        &self,
        suspect: &Suspect,
        lost_links: LostLinks,
        effects: &[Placed],
    ) -> Result<Option<State<'a>>, WalkError> {
        let start = Start::described(self.with_lost(lost_links));
        let first = self.calibrated_from(&start, suspect, effects, Effort::Slopes)?;
        first
            .map(|state| self.calibrated_further(state))
            .transpose()
    }

    /// The same robot with its effects and its model fitted once more, now by polls as well, if it
    /// is likelier for that.
    fn calibrated_further(&self, state: State<'a>) -> Result<State<'a>, WalkError> {
        let effects = &state.trial.effects;
        if effects.is_empty() && !state.is_rough() {
            return Ok(state);
        }
        let further =
            self.calibrated_from(&state.start(), &state.suspect(), effects, Effort::Polls)?;
        Ok(match further {
            Some(further) if further.total < state.total => further,
            _ => state,
        })
    }

    /// A suspect's model calibrated, and then its effects fitted, once. The calibration begins at
    /// `start`.
    pub(super) fn calibrated_from(
        &self,
        start: &Start,
        suspect: &Suspect,
        effects: &[Placed],
        effort: Effort,
    ) -> Result<Option<State<'a>>, WalkError> {
        let settings = &self.settings.comparison;
        let morphology = &suspect.morphology;
        let calibration =
            Calibration::new(settings, start, effects, morphology, self.record, effort)?;
        let Some(calibration) = calibration else {
            return Ok(None);
        };
        let walker = Walker {
            model: &calibration.model,
            morphology,
            body: None,
        };
        let Some(trial) = walker.fit(&calibration.comparison, effects.to_vec(), 0, effort) else {
            return Ok(None);
        };
        let unseen = calibration.comparison.cost_of(trial.unseen_deg2);
        Ok(Some(State {
            morphology: morphology.clone(),
            ln_prior: suspect.ln_prior,
            total: trial.cost + unseen - 2.0 * suspect.ln_prior,
            calibration_model: calibration.model,
            comparison: calibration.comparison,
            trial,
        }))
    }

    /// The errors of the robot as described.
    pub(super) fn as_described(
        &self,
        morphology: &Morphology,
        lost_links: LostLinks,
    ) -> Result<StretchErrors, WalkError> {
        let model = self.with_lost(lost_links);
        let settings = &self.settings.comparison;
        let comparison = Calibration::uncalibrated(settings, &model, morphology, self.record)?
            .ok_or(WalkError::Diverged)?;
        let walker = Walker {
            model: &model,
            morphology,
            body: None,
        };
        let trial = walker.fit(&comparison.as_described(), Vec::new(), 0, Effort::Slopes);
        trial.as_ref().map(errors).ok_or(WalkError::Diverged)
    }
}
