use std::error::Error;

use mlr_filter::{NoMotion, SampledTooSlowly, SettingError, WindowError};
use mlr_imu::quality::Finding;
use mlr_model::ModelError;
use mlr_residual::{SensorError, servo::ServoError};
use thiserror::Error as ThisError;

use crate::{CalibrateError, ExplainError, SteerError, UnfitRobot};

/// Why [`identify()`](crate::identify()) or [`detect`](crate::detect()) has no answer.
#[derive(Debug, ThisError)]
pub enum AnswerError {
    /// The recording does not cover the window after the start of the walk.
    #[error(transparent)]
    Window(#[from] WindowError),
    /// The robot does not move in the recording.
    #[error(transparent)]
    NoMotion(#[from] NoMotion),
    /// Too many time stamps repeat or run backwards.
    #[error(
        "time does not run forward: {dropped} of {total} samples are duplicated or out of order, \
         the first is sample {first}"
    )]
    Disordered {
        /// Samples with a bad time stamp.
        dropped: usize,
        /// Samples in all.
        total: usize,
        /// The first bad one, counted from 1.
        first: usize,
    },
    /// A defect makes the recording useless.
    #[error("{0}")]
    Unusable(Box<Finding>),
    /// The sensor is slower than the time stamps.
    #[error(
        "sampled too slowly: values change {value_rate_hz:.1} times a second in {sample_rate_hz:.0} \
         rows, at least {min_rate_hz:.0} are needed"
    )]
    HeldValues {
        /// Changes per second.
        value_rate_hz: f64,
        /// Rows per second.
        sample_rate_hz: f64,
        /// Changes per second needed.
        min_rate_hz: f64,
    },
    /// No simulation stayed finite.
    #[error(
        "all {simulated} simulated morphologies diverged; the time step is too long for this robot"
    )]
    AllDiverged {
        /// Morphologies simulated.
        simulated: usize,
    },
    /// The search needs an atlas and there is none.
    #[error(
        "no atlas to search of the walks with gait {gait:?}; `mlr-ga atlas build --gait …` makes one, \
         --search ga needs none"
    )]
    NoAtlas {
        /// Name of the gait.
        gait: String,
    },
    /// There is nothing to identify.
    #[error("no log, expected at least one")]
    NoLogs,
    /// A log time that is set for all of several logs.
    #[error(
        "{setting}: a time of one log, expected none for {logs} logs: each has its own; identify them \
         one by one, or leave it out"
    )]
    TimeOfOneLog {
        /// Name of the setting.
        setting: &'static str,
        /// How many logs there are.
        logs: usize,
    },
    /// The paper's method does not search an atlas.
    #[error("the paper's method simulates every candidate, expected search \"ga\" or \"exact\"")]
    AtlasForPaper,
    /// The window reaches beyond the walks of the atlas.
    #[error("walks of {needed_s:.1} s are needed, the atlas holds {there_s:.1} s")]
    AtlasTooShort {
        /// Length that the window and its place in the gait need.
        needed_s: f64,
        /// Length of the atlas's walks.
        there_s: f64,
    },
    /// The robot walks for less time than the damage detector needs, and was not flagged.
    #[error(
        "too short to tell damage: the log shows {walked_s:.1} s of walking, at least \
         {needed_s:.1} s are needed (detector.window_s and detector.persistence_s)"
    )]
    TooShortToDetect {
        /// Length of the walk in the recording.
        walked_s: f64,
        /// Length of the detector's window, and for how long the fluctuation must go on.
        needed_s: f64,
    },
    /// A setting makes no sense.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The recording is sampled too slowly for the damage detector.
    #[error(transparent)]
    SampledTooSlowly(#[from] SampledTooSlowly),
    /// Robot, gait and simulation settings do not fit together.
    #[error(transparent)]
    Model(#[from] ModelError),
}

impl From<Finding> for AnswerError {
    fn from(finding: Finding) -> Self {
        Self::Unusable(Box::new(finding))
    }
}

impl AnswerError {
    /// Whether the recording is at fault, rather than what was asked of it.
    pub fn is_recordings_fault(&self) -> bool {
        matches!(
            self,
            Self::Window(_)
                | Self::NoMotion(_)
                | Self::Unusable(_)
                | Self::HeldValues { .. }
                | Self::Disordered { .. }
                | Self::TooShortToDetect { .. }
                | Self::SampledTooSlowly(_)
        )
    }
}

/// Whether an error of this crate, or of those that it builds on, says that what was recorded cannot
/// answer: exit status 1 of the command line. Whatever else is wrong is wrong usage or unreadable input.
pub fn says_log_cannot_answer(error: &(dyn Error + 'static)) -> bool {
    fn is<E: Error + 'static>(error: &(dyn Error + 'static), faulty: fn(&E) -> bool) -> bool {
        error.downcast_ref().is_some_and(faulty)
    }
    error.is::<UnfitRobot>()
        || is(error, AnswerError::is_recordings_fault)
        || is(error, ExplainError::is_recordings_fault)
        || is(error, CalibrateError::is_recordings_fault)
        || is(error, SteerError::is_recordings_fault)
        || is(error, SensorError::is_recordings_fault)
        || is(error, ServoError::is_recordings_fault)
}
