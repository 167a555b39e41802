use std::{fmt, ops::Range};

use serde::Serialize;

/// Something that is wrong with a log.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Finding {
    /// What.
    pub kind: FindingKind,
    /// How bad it is.
    pub severity: Severity,
    /// Log time at which it begins.
    pub from_s: f64,
    /// Log time at which it ends.
    pub to_s: f64,
    /// What was seen, in words.
    pub reason: String,
    /// What to type or to do about it, where that is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cure: Option<String>,
}

/// What can be wrong with a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum FindingKind {
    /// All values repeat bit for bit.
    Frozen,
    /// The accelerometer is dead.
    DeadAccelerometer,
    /// The gyroscope is dead.
    DeadGyroscope,
    /// Values beyond every range, or jumps that no body can make.
    Impossible,
    /// Values that alternate between those of two sensors.
    Interleaved,
    /// Each value is repeated: the sensor is slower than the stamps.
    Held,
    /// Angles that cannot be in the unit they were read in.
    AngleUnit,
    /// Rates that cannot be in the unit they were read in.
    RateUnit,
    /// Accelerations that cannot be in the unit they were read in.
    AccelerationUnit,
    /// A gravity that is far from 9.81 m/s².
    Gravity,
    /// The sensor's z axis points down.
    UpsideDown,
    /// The sensor's axes are not the body's.
    Axes,
    /// Angles and raw samples that contradict each other.
    Contradiction,
    /// Values cut off at the ends of a range.
    Saturated,
    /// The body tips further than a robot that walks.
    TippedOver,
}

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// Where it is, the log says nothing about the robot.
    Useless,
    /// The log may mislead: answers from it are less sure.
    Worse,
    /// Worth knowing.
    Note,
}

impl Finding {
    /// Whether it spoils a stretch of log time.
    pub(super) fn spoils(&self, stretch_s: &Range<f64>) -> bool {
        self.severity == Severity::Useless
            && self.from_s < stretch_s.end
            && self.to_s > stretch_s.start
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.reason)?;
        match &self.cure {
            Some(cure) => write!(f, "; try {cure}"),
            None => Ok(()),
        }
    }
}
