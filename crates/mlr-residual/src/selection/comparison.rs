//! Whether a candidate is accepted.

use super::{SelectionSettings, trial::Trial};
use crate::{
    sensor_effects::{Commonness, SensorEffect},
    statistics::sign_flip_p_value,
};

/// An error counts as more than noise when it exceeds the noise floor this many times:
/// a random walk that is twice as large as on average is not rare.
pub(super) const ABOVE_NOISE: f64 = 3.0;
/// Two candidates are rivals unless a sign-flip test tells them apart at this level.
const RIVAL_SIGNIFICANCE: f64 = 0.05;

/// A candidate beside the model without it, on the selection stretch.
#[derive(Debug)]
pub(super) struct Comparison {
    pub(super) effect: &'static dyn SensorEffect,
    pub(super) trial: Trial,
    /// Probability of a gain as large, had the effect none.
    pub(super) p_value: f64,
    pub(super) accepted: bool,
    pub(super) verdict: String,
}

impl Comparison {
    /// Compares `trial`, which has the effect, with `current`, which has not. The p-value must
    /// be below `threshold`.
    pub(super) fn new(
        current: &Trial,
        trial: Trial,
        effect: &'static dyn SensorEffect,
        settings: &SelectionSettings,
        threshold: f64,
    ) -> Self {
        let factor = if effect.commonness() == Commonness::Rare {
            2.0
        } else {
            1.0
        };
        let penalty =
            settings.penalty_per_parameter * factor * added_parameters(current, &trial) as f64;
        let falls = |old: f64, new: f64| new <= (1.0 - penalty) * old;
        let within_falls = falls(current.blocks.within_deg(), trial.blocks.within_deg());
        let level_falls = falls(current.selection_deg, trial.selection_deg);
        let within_p = sign_flip_p_value(&current.blocks.within, &trial.blocks.within);
        let level_p = sign_flip_p_value(&current.blocks.level, &trial.blocks.level);
        let drift_is_evidence = if effect.observes_drift() {
            falls(current.fit_deg, trial.fit_deg)
        } else {
            current.selection_deg > ABOVE_NOISE * current.noise_floor_deg()
        };
        let worse = trial.selection_deg > current.selection_deg;
        let by_within = within_falls && within_p < threshold && !worse;
        let by_level = level_falls && level_p < threshold && drift_is_evidence;
        let p_value = match (by_within, by_level) {
            (true, _) => within_p,
            (false, true) => level_p,
            (false, false) => within_p.min(level_p),
        };
        let at_bound = trial.model.is_at_bound(effect.kind());
        let absent = trial.model.is_absent(effect.kind());
        let accepted = (by_within || by_level) && !at_bound && !absent;
        let verdict = if at_bound {
            "helps only beyond what such sensors have".into()
        } else if absent {
            "its 95 % intervals on the fit stretch include no effect".into()
        } else if accepted {
            "within noise of what was added".into()
        } else if worse {
            "worse on the selection stretch".into()
        } else if !(within_falls || level_falls) {
            "gains less than its complexity penalty".into()
        } else if level_falls && level_p < threshold {
            "a smaller drift, as noise alone could leave".into()
        } else {
            format!("not significant (p = {p_value:.4}, needed {threshold:.4})")
        };
        Self {
            effect,
            trial,
            p_value,
            accepted,
            verdict,
        }
    }

    /// By how much the logarithms of the errors have fallen for each parameter. An effect with
    /// many parameters can imitate a simpler one, and must not be preferred for that.
    pub(super) fn gain_per_parameter(&self, current: &Trial) -> f64 {
        let added = added_parameters(current, &self.trial);
        (current.score() - self.trial.score()) / added as f64
    }

    /// Whether its error does not differ significantly from that of the best candidate, which
    /// is another.
    pub(super) fn is_rival_of(&self, best: &Self) -> bool {
        self.effect.kind() != best.effect.kind()
            && sign_flip_p_value(&self.trial.blocks.level, &best.trial.blocks.level)
                > RIVAL_SIGNIFICANCE
    }
}

fn added_parameters(current: &Trial, trial: &Trial) -> usize {
    let (before, after) = (
        current.model.parameter_count(),
        trial.model.parameter_count(),
    );
    after.saturating_sub(before).max(1)
}
