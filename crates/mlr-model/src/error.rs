use thiserror::Error;

/// Everything that can be wrong with a robot, a gait, a morphology or the
/// settings of a simulation.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A robot or gait file is not valid TOML of the expected form.
    #[error("{what}: {source}")]
    Syntax {
        /// "robot" or "gait".
        what: &'static str,
        /// Names line, column and the expected form.
        source: Box<toml::de::Error>,
    },
    /// A value is well-formed but makes no sense.
    #[error("{field}: {value} is not valid, expected {expected}")]
    Value {
        /// Path of the value, as in `legs[2].hip_m`.
        field: String,
        /// The value found.
        value: String,
        /// What it should have been.
        expected: &'static str,
    },
    /// The gait asks a foot to be where the leg cannot bring it.
    #[error(
        "leg {leg} cannot reach the gait's foot target ({x_m:.4}, {y_m:.4}, {z_m:.4}) m at gait time {time_s:.3} s: \
         it stops {miss_m:.4} m short"
    )]
    Unreachable {
        /// Leg number, from 1.
        leg: usize,
        /// Gait time of the target.
        time_s: f64,
        /// Target, body frame.
        x_m: f64,
        /// Target, body frame.
        y_m: f64,
        /// Target, body frame.
        z_m: f64,
        /// Distance between the target and the nearest point found.
        miss_m: f64,
    },
    /// The gait was made for a robot with another number of legs.
    #[error("the gait has {gait} phase offsets, the robot has {robot} legs")]
    LegCount {
        /// Phase offsets of the gait.
        gait: usize,
        /// Legs of the robot.
        robot: usize,
    },
    /// A morphology's text or numbers do not fit the robot.
    #[error("morphology {text:?}: {reason}")]
    Morphology {
        /// What was given.
        text: String,
        /// Why it does not fit.
        reason: String,
    },
}

impl ModelError {
    /// A [`ModelError::Value`] for `field`.
    pub(crate) fn value(
        field: impl Into<String>,
        value: impl std::fmt::Display,
        expected: &'static str,
    ) -> Self {
        Self::Value {
            field: field.into(),
            value: value.to_string(),
            expected,
        }
    }

    /// Checks that `value` is finite and within `low..=high`.
    pub(crate) fn check_range(
        field: impl Into<String>,
        value: f64,
        low: f64,
        high: f64,
        expected: &'static str,
    ) -> Result<(), Self> {
        if (low..=high).contains(&value) {
            Ok(())
        } else {
            Err(Self::value(field, value, expected))
        }
    }
}
