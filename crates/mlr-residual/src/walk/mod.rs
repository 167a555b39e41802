//! The walk of a robot with its sensor: model, record, and how far they are apart.

mod calibration;
mod comparison;
mod decomposition;
mod model;
mod poll;
mod record;
mod remainder;
mod report;
mod sensing;
mod tracing;
mod trial;
mod usual;

pub use calibration::ComparisonSettings;
pub use comparison::ErrorWeights;
pub use decomposition::{AxisResidual, Harmonic};
pub use model::WalkModel;
pub use record::WalkRecord;
pub use remainder::{Allowance, Leavings, UsualRemainder};
pub use report::{
    ByAxis, RemainingResidual, Reported, Rival, StretchErrors, TracedEffect, WalkCandidate,
    WalkExplanation,
};
pub use sensing::Sensing;
pub use tracing::{MorphologySearch, Suspect, TracingSettings, explain_walk};
pub use usual::UsualDifferences;

pub(crate) use calibration::{Calibration, Start};
pub(crate) use comparison::{Comparison, Settled};
pub(crate) use model::Prediction;
pub(crate) use poll::{Effort, Poll};
pub(crate) use trial::{Placed, Trial, Walker};
pub(crate) use usual::Trace;

use thiserror::Error;

/// Why a walk cannot be explained.
#[derive(Debug, Error)]
pub enum WalkError {
    /// There is too little of it.
    #[error(
        "the log shows {walked_s:.1} s of the walk, expected at least {needed_s:.1} s: half to fit effects, half to judge them"
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
    /// A setting of the tracing makes no sense.
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
