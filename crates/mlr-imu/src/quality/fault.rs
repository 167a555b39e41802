use std::fmt;

use serde::Serialize;

/// Samples that say nothing about the body, and since when.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SampleFault {
    kind: FaultKind,
    since_s: f64,
}

/// How samples can be worthless.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    /// Every channel repeats bit for bit.
    Frozen,
    /// The accelerometer shows no gravity, or repeats while the gyroscope does not.
    DeadAccelerometer,
    /// The gyroscope repeats while the accelerometer does not.
    DeadGyroscope,
    /// Values stay at the ends of the sensor's range.
    Saturated,
    /// Values that no body produces: beyond every range, or jumping to and fro.
    Impossible,
}

impl SampleFault {
    pub(super) fn new(kind: FaultKind, since_s: f64) -> Self {
        Self { kind, since_s }
    }

    /// Which fault.
    pub fn kind(&self) -> FaultKind {
        self.kind
    }

    /// Time of the first sample that had it.
    pub fn since_s(&self) -> f64 {
        self.since_s
    }
}

impl FaultKind {
    /// The name that programs read, as in `dead_gyroscope`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Frozen => "frozen",
            Self::DeadAccelerometer => "dead_accelerometer",
            Self::DeadGyroscope => "dead_gyroscope",
            Self::Saturated => "saturated",
            Self::Impossible => "impossible",
        }
    }

    fn in_words(self) -> &'static str {
        match self {
            Self::Frozen => "all values repeat bit for bit: the sensor is frozen",
            Self::DeadAccelerometer => {
                "the accelerometer shows no gravity or does not change: it is dead"
            }
            Self::DeadGyroscope => {
                "the rates repeat bit for bit while the accelerations change: the gyroscope is dead"
            }
            Self::Saturated => {
                "values stay at the end of the sensor's range: choose a larger full-scale range"
            }
            Self::Impossible => {
                "values jump as no body does: more than one sensor on the line, or damaged frames"
            }
        }
    }
}

impl fmt::Display for SampleFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, since {:.2} s", self.kind.in_words(), self.since_s)
    }
}
