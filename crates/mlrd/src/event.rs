//! What the daemon says on stdout: one JSON object per line.

use std::{path::PathBuf, time::SystemTime};

use mlr_ga::{CalibrationReport, ExplanationReport, IdentificationReport, RecoveryReport};
use mlr_model::Robot;
use mlr_residual::walk::Sensing;
use serde::{Deserialize, Serialize};

use crate::{
    learning::{KnownCalibration, Wear},
    saved_state::KnownMorphology,
};

/// One line. `t_s` counts from the first sample.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Event<'a> {
    time: String,
    t_s: f64,
    #[serde(flatten)]
    kind: &'a Kind,
    level: Level,
}

/// How bad it is, as in ROS diagnostics.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// As it should be.
    Ok = 0,
    /// Worth a look.
    Warn = 1,
    /// Something is broken.
    Error = 2,
    /// Nothing is heard.
    Stale = 3,
}

#[cfg(feature = "top")]
impl Level {
    /// The level of this number; what is beyond all of them is as the last one.
    pub(crate) fn of_number(number: u64) -> Self {
        match number {
            0 => Self::Ok,
            1 => Self::Warn,
            2 => Self::Error,
            _ => Self::Stale,
        }
    }
}

impl Serialize for Level {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u8(*self as u8)
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for Level {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Level".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "How bad it is, as in ROS diagnostics: 0 OK, 1 WARN, 2 ERROR, 3 STALE.",
            "type": "integer",
            "minimum": 0,
            "maximum": 3
        })
    }
}

/// What happened.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Kind {
    /// The daemon runs.
    Started {
        /// The port it is going to read.
        port: String,
        /// The robot that it watches.
        robot: WatchedRobot,
        /// What was last identified, before this start.
        #[serde(skip_serializing_if = "Option::is_none")]
        last_known: Option<KnownMorphology>,
        /// What was learned of the robot before this start.
        #[serde(skip_serializing_if = "Option::is_none")]
        calibration: Option<KnownCalibration>,
    },
    /// The port delivers bytes.
    PortOpened {
        /// Its name.
        port: String,
    },
    /// The port cannot be opened, or is gone.
    PortLost {
        /// Why.
        reason: String,
    },
    /// Bytes arrive, and no frame is understood.
    LineFault {
        /// Why, as far as can be told.
        reason: String,
    },
    /// Frames are understood, and what they say cannot be: nothing is concluded from it
    /// until the sensor has recovered.
    SensorFault {
        /// Its short name.
        fault: &'static str,
        /// What is wrong, in words.
        reason: String,
        /// Time of the first sample that was wrong.
        since_s: f64,
    },
    /// What the sensor says makes sense again.
    SensorRecovered {
        /// The fault that it had.
        fault: &'static str,
        /// Time from its first wrong sample to its recovery.
        lasted_s: f64,
    },
    /// The robot walks.
    MotionStarted {
        /// When it started.
        motion_start_s: f64,
    },
    /// Roll or pitch fluctuate as a healthy robot's do not.
    DamageDetected {
        /// Fluctuation within the detector's window.
        fluctuation_deg: f64,
        /// Whether the robot was known to be damaged and moves otherwise now.
        changed: bool,
    },
    /// The damage is known.
    Identified {
        /// As `mlr-ga identify` reports it.
        result: Box<IdentificationReport>,
    },
    /// The damage cannot be identified.
    Unidentified {
        /// Why.
        reason: String,
    },
    /// What else is unusual about the walk that was identified is known.
    Explained {
        /// As `mlr-ga explain` reports it.
        result: Box<ExplanationReport>,
    },
    /// A gait was found that walks again with what is left of the robot. Nothing is commanded.
    RecoveryGait {
        /// The gait in TOML, which every command takes as --gait.
        gait: PathBuf,
        /// The same as the joint angles that a controller plays.
        joints: PathBuf,
        /// As `mlr-ga recover` reports it.
        result: Box<RecoveryReport>,
    },
    /// A healthy walk told more of the robot: identifications and explanations use it from now on.
    Calibrated {
        /// As `mlr-ga calibrate` reports it.
        result: Box<CalibrationReport>,
        /// Stretches of healthy walk that went into it.
        walks: u32,
        /// By how much it predicts another walk better than what was known before: logarithm of the
        /// evidence.
        gain_nats: f64,
        /// What has drifted since the robot was first known.
        wear: Vec<Wear>,
    },
    /// An explanation found the sensor at fault: recordings are corrected from now on.
    SensorCorrected {
        /// All that is corrected.
        sensing: Sensing,
    },
    /// The robot walks calmly again.
    Recovered,
    /// What was to be kept in a file could not be, or something else that does not
    /// stop the daemon.
    Warning {
        /// What, and why.
        reason: String,
    },
    /// A recording was begun.
    RecordingBegun {
        /// Its file.
        path: PathBuf,
    },
    /// An old recording was removed to make room.
    RecordingRemoved {
        /// Its file.
        path: PathBuf,
    },
    /// How things are, once in a while.
    Status(Box<Status>),
    /// The daemon ends.
    Stopped,
}

/// A robot as far as it must be known to draw its legs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WatchedRobot {
    /// Its name.
    pub name: String,
    /// Its legs, in the order of their numbers.
    pub legs: Vec<WatchedLeg>,
}

/// One leg from above.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WatchedLeg {
    /// Its name.
    pub name: String,
    /// Where it is joined to the body: x forward and y to the left, in the body's frame.
    pub hip_m: [f64; 2],
    /// How many links it has when it is whole.
    pub links: usize,
}

impl WatchedRobot {
    /// This robot.
    pub fn new(robot: &Robot) -> Self {
        let legs = robot.legs().iter().map(|leg| WatchedLeg {
            name: leg.name.clone(),
            hip_m: [leg.hip_m.x, leg.hip_m.y],
            links: leg.links.len(),
        });
        Self {
            name: robot.name().into(),
            legs: legs.collect(),
        }
    }
}

/// How things are.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Status {
    /// Valid frames.
    pub good: u64,
    /// Frames that failed their check.
    pub bad: u64,
    /// Frames that never came.
    pub lost: u64,
    /// What the monitor is doing.
    pub state: &'static str,
    /// Short name of what is wrong with the sensor now.
    pub fault: Option<&'static str>,
    /// Time since the last valid sample, or since the start without one.
    pub silent_s: f64,
    /// Samples per second since the last status.
    pub rate_hz: Option<f64>,
    /// Roll of the body when last known.
    pub roll_deg: Option<f64>,
    /// Its pitch.
    pub pitch_deg: Option<f64>,
    /// How far roll or pitch swing within the damage detector's window now; null where that is not known.
    pub fluctuation_deg: Option<f64>,
    /// The largest of it in each whole second since the last status, the oldest first; of a minute at most.
    pub fluctuations_deg: Vec<f64>,
    /// What a healthy robot stays below.
    pub threshold_deg: f64,
    /// How many `status` before this one were dropped because nobody read them.
    pub dropped_status: u64,
    /// How many other events were.
    pub dropped_events: u64,
}

/// A sensor that says nothing for so long is stale.
const SILENT_S: f64 = 2.0;

impl Kind {
    fn level(&self) -> Level {
        match self {
            Self::PortLost { .. } => Level::Stale,
            Self::Status(status) if status.silent_s > SILENT_S => Level::Stale,
            Self::Status(status) if status.fault.is_some() => Level::Error,
            Self::DamageDetected { .. } | Self::Warning { .. } => Level::Warn,
            Self::Calibrated { wear, .. } if !wear.is_empty() => Level::Warn,
            Self::Unidentified { .. } | Self::LineFault { .. } | Self::SensorFault { .. } => {
                Level::Error
            }
            Self::Identified { result } if result.identification.implausible => Level::Warn,
            Self::Identified { result } if !result.identification.damaged_legs.is_empty() => {
                Level::Error
            }
            Self::Explained { result }
                if result.explanation.unexplained || !result.explanation.effects.is_empty() =>
            {
                Level::Warn
            }
            Self::RecoveryGait { result, .. } if !result.statically_stable => Level::Warn,
            _ => Level::Ok,
        }
    }
}

/// The line for an event, without the line end.
///
/// # Errors
/// When the event holds what JSON cannot express.
pub fn line(now: SystemTime, t_s: f64, kind: &Kind) -> serde_json::Result<String> {
    serde_json::to_string(&Event {
        time: humantime::format_rfc3339_millis(now).to_string(),
        t_s,
        kind,
        level: kind.level(),
    })
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use mlr_imu::quality::LogQuality;

    use super::*;
    use crate::explainer::tests::{faulty_sensor, nothing_unusual};

    #[test]
    fn an_explanation_that_found_something_is_worth_a_look() {
        let level = |explanation| {
            let result = Box::new(ExplanationReport::new(
                "imu".into(),
                1,
                explanation,
                LogQuality::default(),
                Duration::ZERO,
            ));
            Kind::Explained { result }.level()
        };
        assert_eq!(level(nothing_unusual()), Level::Ok);
        assert_eq!(
            level(faulty_sensor("gyro_scale", &[("scale", 1.1)])),
            Level::Warn
        );
        let mut unexplained = nothing_unusual();
        unexplained.unexplained = true;
        assert_eq!(level(unexplained), Level::Warn);
    }

    fn status(silent_s: f64, fault: Option<&'static str>) -> Kind {
        Kind::Status(Box::new(Status {
            good: 7,
            bad: 0,
            lost: 0,
            state: "standing",
            fault,
            silent_s,
            rate_hz: Some(500.0),
            roll_deg: None,
            pitch_deg: None,
            fluctuation_deg: None,
            fluctuations_deg: Vec::new(),
            threshold_deg: 5.0,
            dropped_status: 0,
            dropped_events: 0,
        }))
    }

    #[test]
    fn a_silent_sensor_is_stale_and_a_faulty_one_an_error() {
        assert_eq!(status(0.1, None).level(), Level::Ok);
        assert_eq!(status(0.1, Some("frozen")).level(), Level::Error);
        assert_eq!(status(2.5, Some("frozen")).level(), Level::Stale);
    }

    #[test]
    fn what_a_status_does_not_know_is_null() {
        let line = line(SystemTime::UNIX_EPOCH, 0.0, &status(0.5, None)).unwrap();
        let event: serde_json::Value = serde_json::from_str(&line).unwrap();
        assert_eq!(
            (&event["event"], &event["level"]),
            (&"status".into(), &0.into())
        );
        assert_eq!(
            (&event["good"], &event["rate_hz"]),
            (&7.into(), &500.0.into())
        );
        for unknown in ["fault", "roll_deg", "pitch_deg", "fluctuation_deg"] {
            assert!(event.get(unknown).is_some_and(serde_json::Value::is_null));
        }
    }

    #[test]
    fn a_line_has_time_event_and_level() {
        let now = SystemTime::UNIX_EPOCH + Duration::from_millis(1_500);
        let reason = "unplugged".to_string();
        let line = line(now, 2.5, &Kind::PortLost { reason }).unwrap();
        assert_eq!(
            line,
            r#"{"time":"1970-01-01T00:00:01.500Z","t_s":2.5,"event":"port_lost","reason":"unplugged","level":3}"#
        );
    }
}
