use thiserror::Error;

/// Why a sensor's record has no answer.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SensorError {
    /// A setting makes no sense.
    #[error(transparent)]
    Setting(#[from] mlr_filter::SettingError),
    /// The columns do not have the same length.
    #[error("{column} has {found} samples, the time stamps are {expected}")]
    Length {
        /// Which column.
        column: &'static str,
        /// Samples it has.
        found: usize,
        /// Samples it should have.
        expected: usize,
    },
    /// The record is too short to be divided into fit, selection and test.
    #[error(
        "too short: {duration_s:.2} s in {samples} samples, at least {needed_s:.0} s in {needed_samples} samples are needed"
    )]
    TooShort {
        /// Length of the record.
        duration_s: f64,
        /// Samples in it.
        samples: usize,
        /// Length needed.
        needed_s: f64,
        /// Samples needed.
        needed_samples: usize,
    },
    /// One of the stretches has too few samples.
    #[error(
        "too few samples from {from_s:.2} s to {to_s:.2} s: {samples}, at least {needed} are needed"
    )]
    Gap {
        /// Begin of the stretch, log time.
        from_s: f64,
        /// End of the stretch, log time.
        to_s: f64,
        /// Samples in it.
        samples: usize,
        /// Samples needed.
        needed: usize,
    },
    /// The reference never turns.
    #[error(
        "no motion: the reference angle moves by {range_deg:.2}° in the stretch that the \
         parameters are fitted on, at least {needed_deg:.0}° are needed"
    )]
    NoMotion {
        /// Largest less smallest angle.
        range_deg: f64,
        /// Range needed.
        needed_deg: f64,
    },
    /// Too many time stamps repeat or run backwards.
    #[error(
        "time does not run forward: {dropped} of {total} samples are not later than the one before"
    )]
    Disordered {
        /// Samples with a bad time stamp.
        dropped: usize,
        /// Samples in all.
        total: usize,
    },
    /// An effect of an earlier report is not in the library.
    #[error("no effect of the kind {kind:?}, known are {known}")]
    UnknownEffect {
        /// The kind asked for.
        kind: String,
        /// The kinds of the library.
        known: String,
    },
    /// An effect of an earlier report lacks a parameter or has one too many.
    #[error("effect {kind}: expected the parameters {expected}, found {found}")]
    Parameters {
        /// Kind of the effect.
        kind: String,
        /// Names that it has.
        expected: String,
        /// Names that were given.
        found: String,
    },
}

impl SensorError {
    /// Whether the record is at fault, rather than what was asked of it.
    pub fn is_recordings_fault(&self) -> bool {
        matches!(
            self,
            Self::TooShort { .. }
                | Self::Gap { .. }
                | Self::NoMotion { .. }
                | Self::Disordered { .. }
        )
    }
}
