//! Where the tracing has come to.

use std::{collections::BTreeMap, sync::Arc};

use mlr_model::{LostLinks, Morphology};

use super::Suspect;
use crate::walk::{
    Comparison, Start, Trial, WalkModel, Walker, comparison::is_rough, usual::Difference,
};

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

    pub(super) fn is_rough(&self) -> bool {
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
