//! The walk of a robot with its sensor: model, record, and how probable it is that the model lacks an
//! effect.

mod answer;
mod calibrated_walk;
mod calibration;
mod decomposition;
mod discrepancy;
mod drawn;
mod evidence;
mod hypothesis;
mod information;
mod linear_model;
mod mean_walk;
mod model;
mod nuisance;
mod observation;
mod outcome;
mod record;
mod report;
mod residual_left;
mod search;
mod sensing;
mod settings;
mod stretch_errors;

pub use answer::explain_walk;
pub use calibrated_walk::{
    CalibratedParameter, CalibratedWalk, KnownEffect, KnownRobot, Simulated,
};
pub use calibration::{CalibratedRobot, calibrate_walk};
pub use decomposition::{AxisResidual, Harmonic};
pub use discrepancy::{Amplitude, AxisDiscrepancy, Discrepancy, MissedShare, TurningDiscrepancy};
pub use information::{BrokenBound, Ensemble, Information, MotionBounds};
pub use model::WalkModel;
pub use nuisance::NuisanceSettings;
pub use outcome::LOCKED_LINKS;
pub use record::WalkRecord;
pub use report::{
    ByAxis, RemainingResidual, Reported, Rival, StretchErrors, StretchesS, TracedEffect,
    WalkAlternative, WalkCandidate, WalkExplanation,
};
pub use search::{Beforehand, Effort, Suspect, earlier::EarlierEffects, prior::EffectPrior};
pub use sensing::Sensing;
pub use settings::EvidenceSettings;

pub(crate) use model::Prediction;
pub(crate) use nuisance::{Nuisance, NuisancePrior};
pub(crate) use observation::Observation;

use thiserror::Error;

/// Why a walk cannot be explained.
#[derive(Debug, Error)]
pub enum WalkError {
    /// There is too little of it.
    #[error(
        "the log shows {walked_s:.1} s of the walk, expected at least {needed_s:.1} s: two thirds to weigh hypotheses, the rest to measure errors"
    )]
    TooShort {
        /// What there is.
        walked_s: f64,
        /// What it takes.
        needed_s: f64,
    },
    /// The model as described does not stay upright, or the numbers grow without limit.
    #[error("the simulated walk of the robot as identified diverges")]
    Diverged,
    /// A setting makes no sense.
    #[error(transparent)]
    Setting(#[from] mlr_filter::SettingError),
    /// Robot, gait or settings of the simulation make no sense.
    #[error(transparent)]
    Model(#[from] mlr_model::ModelError),
}

impl WalkError {
    /// Whether the recording is at fault, rather than the settings.
    pub fn is_recordings_fault(&self) -> bool {
        matches!(self, Self::TooShort { .. } | Self::Diverged)
    }
}
