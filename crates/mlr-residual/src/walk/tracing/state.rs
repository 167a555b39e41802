//! Where the tracing has come to, and which morphology suits it.

use std::collections::BTreeMap;

use mlr_model::{LostLinks, Morphology};
use rayon::prelude::*;

use super::{Suspect, Tracing, errors};
use crate::walk::{
    Calibration, Comparison, Placed, StretchErrors, Trial, WalkError, WalkModel, Walker,
    usual::Difference,
};

/// Morphologies that are calibrated in full after a first look at all.
const FINALISTS: usize = 2;
/// Turns of calibration and fit, and the gain below which they have settled.
const TURNS: usize = 2;
const SETTLED: f64 = 0.5;
/// How much less probable a morphology may be after the first look, in the units of cost.
const WITHIN: f64 = 25.0;

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

    pub(super) fn walker(&self) -> Walker<'_> {
        Walker {
            model: &self.calibration_model,
            morphology: &self.morphology,
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

impl<'a> Tracing<'a> {
    /// The suspect whose walk with these effects leaves least: all are looked at, the
    /// best few calibrated in full.
    pub(super) fn likeliest(
        &self,
        suspects: &[Suspect],
        effects: &[Placed],
    ) -> Result<Option<State<'a>>, WalkError> {
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
        let finalists = if suspects.len() == 1 {
            cases
        } else {
            self.finalists(cases, effects)?
        };
        self.progress.expect_more(finalists.len());
        let states = finalists
            .into_par_iter()
            .map(|(suspect, lost_links)| {
                let state = self.calibrated(suspect, lost_links, effects);
                self.progress.advance();
                state
            })
            .collect::<Result<Vec<_>, WalkError>>()?;
        let states = states.into_iter().flatten();
        Ok(states.min_by(|a, b| a.total.total_cmp(&b.total)))
    }

    /// Looks at all cases and chooses the best few.
    pub(super) fn finalists<'s>(
        &self,
        cases: Vec<(&'s Suspect, LostLinks)>,
        effects: &[Placed],
    ) -> Result<Vec<(&'s Suspect, LostLinks)>, WalkError> {
        self.progress.expect_more(cases.len());
        let mut glances = cases
            .into_par_iter()
            .map(|(suspect, lost_links)| {
                let cost = Calibration::glance(
                    &self.settings.comparison,
                    &self.with_lost(lost_links),
                    effects,
                    &suspect.morphology,
                    self.record,
                )?;
                self.progress.advance();
                Ok(cost.map(|cost| (cost - 2.0 * suspect.ln_prior, suspect, lost_links)))
            })
            .collect::<Result<Vec<_>, WalkError>>()?
            .into_iter()
            .flatten()
            .collect::<Vec<_>>();
        glances.sort_by(|(a, ..), (b, ..)| a.total_cmp(b));
        let best = glances.first().map_or(0.0, |(cost, ..)| *cost);
        glances.retain(|(cost, ..)| *cost <= best + WITHIN);
        let chosen = glances.into_iter().take(FINALISTS);
        Ok(chosen
            .map(|(_, suspect, lost_links)| (suspect, lost_links))
            .collect())
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

    /// The likeliest of the suspects, unless it is hardly likelier than the morphology held
    /// so far.
    pub(super) fn likeliest_beside(
        &self,
        so_far: &State<'a>,
        suspects: &[Suspect],
        effects: &[Placed],
    ) -> Result<State<'a>, WalkError> {
        let others: Vec<Suspect> = suspects
            .iter()
            .filter(|suspect| suspect.morphology != so_far.morphology)
            .cloned()
            .collect();
        if others.is_empty() {
            return Ok(so_far.clone());
        }
        let other = self.likeliest(&others, effects)?;
        let other = other.filter(|other| other.total < so_far.total - self.settings.switch_gain);
        Ok(other.unwrap_or_else(|| so_far.clone()))
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
        let turns = if effects.is_empty() { 1 } else { TURNS };
        let mut best: Option<State<'a>> = None;
        for _ in 0..turns {
            let effects = best.as_ref().map_or(effects, |best| &best.trial.effects);
            let Some(next) = self.calibrated_once(suspect, lost_links, effects)? else {
                break;
            };
            if best
                .as_ref()
                .is_some_and(|best| next.total > best.total - SETTLED)
            {
                break;
            }
            best = Some(next);
        }
        Ok(best)
    }

    pub(super) fn calibrated_once(
        &self,
        suspect: &Suspect,
        lost_links: LostLinks,
        effects: &[Placed],
    ) -> Result<Option<State<'a>>, WalkError> {
        let model = self.with_lost(lost_links);
        let comparison = &self.settings.comparison;
        let morphology = &suspect.morphology;
        let Some(calibration) =
            Calibration::new(comparison, &model, effects, morphology, self.record)?
        else {
            return Ok(None);
        };
        let walker = Walker {
            model: &calibration.model,
            morphology,
        };
        let Some(trial) = walker.fit(&calibration.comparison, effects.to_vec(), 0) else {
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
        };
        let trial = walker.fit(&comparison.as_described(), Vec::new(), 0);
        trial.as_ref().map(errors).ok_or(WalkError::Diverged)
    }
}
