//! One robot with the model calibrated around its effects.

use mlr_model::{LostLinks, Morphology};

use super::{Suspect, Tracing, errors, state::State};
use crate::walk::{
    Calibration, Effort, Placed, Start, StretchErrors, Trial, WalkError, WalkModel, Walker,
    usual::Difference,
};

/// Usual differences of the body in a model that cost less than this leave room for effects.
const WORTH_UNDOING: f64 = 2.0;

impl<'a> Tracing<'a> {
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
    pub(super) fn calibrated_further(&self, state: State<'a>) -> Result<State<'a>, WalkError> {
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

    /// A morphology, with what is known of it beside the record.
    pub(super) fn suspect(&self, morphology: Morphology) -> Suspect {
        Suspect {
            ln_prior: self.search.ln_prior(&morphology),
            morphology,
        }
    }
}
