//! Events as they are read: no more of them than is shown, and nothing that an older or a newer
//! daemon may lack or add is missed.

use std::{collections::BTreeMap, path::PathBuf};

use mlr_imu::printable;
use mlr_model::Morphology;
use serde::Deserialize;
use serde_json::Value;

use crate::{
    event::{Level, WatchedRobot},
    learning::KnownCalibration,
    saved_state::KnownMorphology,
};

/// One line of the stream.
#[derive(Debug, Clone, PartialEq)]
pub enum Line {
    /// What the daemon told.
    Event(Box<Told>),
    /// What is no event: a message for people, for instance.
    Other(String),
}

/// An event.
#[derive(Debug, Clone, PartialEq)]
pub struct Told {
    /// By the daemon's wall clock, RFC 3339.
    pub time: String,
    /// Time since the first sample.
    pub t_s: f64,
    /// How bad it is.
    pub level: Level,
    /// Its name.
    pub name: String,
    /// What it says.
    pub what: What,
}

/// What an event says, as far as it is shown. Its fields are those of [`Kind`](crate::event::Kind).
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "event", rename_all = "snake_case")]
#[allow(
    missing_docs,
    reason = "named and described where the daemon writes them"
)]
pub enum What {
    Started {
        port: String,
        robot: Option<WatchedRobot>,
        last_known: Option<KnownMorphology>,
        calibration: Option<KnownCalibration>,
    },
    PortOpened {
        port: String,
    },
    PortLost {
        reason: String,
    },
    LineFault {
        reason: String,
    },
    SensorFault {
        fault: String,
        reason: String,
    },
    SensorRecovered {
        fault: String,
        lasted_s: f64,
    },
    MotionStarted {
        motion_start_s: f64,
    },
    DamageDetected {
        fluctuation_deg: f64,
        changed: bool,
    },
    Identified {
        result: Identified,
    },
    Unidentified {
        reason: String,
    },
    Explained {
        result: Explained,
    },
    RecoveryGait {
        gait: PathBuf,
        joints: PathBuf,
        result: RecoveryGait,
    },
    Calibrated {
        walks: u32,
        gain_nats: f64,
        #[serde(default)]
        wear: Vec<WearTold>,
    },
    SensorCorrected {
        sensing: Corrected,
    },
    Recovered,
    Warning {
        reason: String,
    },
    RecordingBegun {
        path: PathBuf,
    },
    RecordingRemoved {
        path: PathBuf,
    },
    Status(StatusTold),
    Stopped,
    /// An event of a daemon that this program does not know, or that lacks what it should have.
    #[serde(other)]
    Unknown,
}

/// The damage, of `mlr.identification/1`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[allow(missing_docs, reason = "as above")]
pub struct Identified {
    pub morphology: Morphology,
    #[serde(default)]
    pub implausible: bool,
    pub probability: Option<f64>,
    pub legs_probability: Option<f64>,
    #[serde(default)]
    pub leg_damage_probability: Vec<f64>,
    pub elapsed_s: Option<f64>,
}

/// What else is wrong, of `mlr.explanation/1`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[allow(missing_docs, reason = "as above")]
pub struct Explained {
    #[serde(default)]
    pub effects: Vec<Effect>,
    #[serde(default)]
    pub unexplained: bool,
    pub error_before: Option<Errors>,
    pub error_after: Option<Errors>,
}

/// One effect.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[allow(missing_docs, reason = "as above")]
pub struct Effect {
    pub kind: String,
    #[serde(default)]
    pub parameters: BTreeMap<String, Value>,
    pub probability: Option<f64>,
}

/// The error on the stretch that decided nothing.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[allow(missing_docs, reason = "as above")]
pub struct Errors {
    pub validation_deg: Option<f64>,
}

/// How it would walk again, of `mlr.recovery/1`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[allow(missing_docs, reason = "as above")]
pub struct RecoveryGait {
    #[serde(default)]
    pub folded_legs: Vec<usize>,
    #[serde(default)]
    pub statically_stable: bool,
    pub before: Option<Outlook>,
    pub after: Option<Outlook>,
}

/// How robots would walk.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[allow(missing_docs, reason = "as above")]
pub struct Outlook {
    pub reliable_speed_m_per_s: Option<f64>,
}

/// A parameter of the robot that has drifted.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[allow(missing_docs, reason = "as above")]
pub struct WearTold {
    pub parameter: String,
    pub unit: String,
    pub reference: f64,
    pub now: f64,
}

/// What is corrected of the sensor.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(default)]
#[allow(missing_docs, reason = "as above")]
pub struct Corrected {
    pub misalignment_deg: [f64; 3],
    pub bias_dps: [f64; 3],
    pub scale: f64,
    pub delay_s: f64,
}

impl Default for Corrected {
    fn default() -> Self {
        Self {
            misalignment_deg: [0.0; 3],
            bias_dps: [0.0; 3],
            scale: 1.0,
            delay_s: 0.0,
        }
    }
}

/// How things are.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(default)]
#[allow(missing_docs, reason = "as above")]
pub struct StatusTold {
    pub good: u64,
    pub bad: u64,
    pub lost: u64,
    pub state: String,
    pub fault: Option<String>,
    pub silent_s: f64,
    pub rate_hz: Option<f64>,
    pub roll_deg: Option<f64>,
    pub pitch_deg: Option<f64>,
    pub fluctuation_deg: Option<f64>,
    pub fluctuations_deg: Vec<f64>,
    pub threshold_deg: Option<f64>,
    pub dropped_status: u64,
    pub dropped_events: u64,
}

impl Line {
    /// Reads one line of the stream, whatever it is.
    pub fn new(text: &str) -> Self {
        match Told::new(text) {
            Some(told) => Self::Event(Box::new(told)),
            None => Self::Other(printable(text)),
        }
    }
}

/// The value with its texts as a terminal may show them.
fn of_a_terminal(value: Value) -> Value {
    match value {
        Value::String(text) => Value::String(printable(&text).replace('\n', " ")),
        Value::Array(values) => values.into_iter().map(of_a_terminal).collect(),
        Value::Object(fields) => {
            let fields = fields.into_iter();
            fields
                .map(|(name, value)| (printable(&name), of_a_terminal(value)))
                .collect()
        }
        other => other,
    }
}

impl Told {
    /// An event, if the text is one.
    fn new(text: &str) -> Option<Self> {
        /// What all events have.
        #[derive(Deserialize)]
        struct Common {
            time: String,
            #[serde(default)]
            t_s: f64,
            #[serde(default)]
            level: u64,
            event: String,
        }
        let value = of_a_terminal(serde_json::from_str(text).ok()?);
        let common = Common::deserialize(&value).ok()?;
        Some(Self {
            time: common.time,
            t_s: common.t_s,
            level: Level::of_number(common.level),
            name: common.event,
            what: What::deserialize(&value).unwrap_or(What::Unknown),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(text: &str) -> Told {
        match Line::new(text) {
            Line::Event(told) => *told,
            Line::Other(text) => panic!("{text}"),
        }
    }

    #[test]
    fn a_status_of_an_older_daemon_is_one() {
        let text = r#"{"time":"2026-11-22T16:10:58.461Z","t_s":9.0,"event":"status","good":8774,"bad":0,"lost":0,"state":"walking","fault":null,"silent_s":0.1,"rate_hz":974.6,"roll_deg":-0.3,"pitch_deg":null,"dropped_status":0,"dropped_events":0,"level":0}"#;
        let told = told(text);
        let What::Status(status) = told.what else {
            panic!("{told:?}");
        };
        assert_eq!((status.good, status.state.as_str()), (8774, "walking"));
        assert_eq!((status.pitch_deg, status.threshold_deg), (None, None));
    }

    #[test]
    fn what_is_not_known_keeps_its_name_and_level() {
        for text in [
            r#"{"time":"t","event":"teleported","level":2,"where":[1,2]}"#,
            r#"{"time":"t","event":"teleported","level":2}"#,
        ] {
            let told = told(text);
            assert_eq!(told.what, What::Unknown);
            assert_eq!(
                (told.name.as_str(), told.level),
                ("teleported", Level::Error)
            );
        }
        // A field is missing, or of another type.
        for text in [
            r#"{"time":"t","event":"port_lost","level":3}"#,
            r#"{"time":"t","event":"identified","level":2,"result":{"morphology":[[1,2]]}}"#,
        ] {
            assert_eq!(told(text).what, What::Unknown, "{text}");
        }
    }

    #[test]
    fn what_is_no_event_is_shown_as_it_is() {
        for text in ["", "sensor: frozen", "{", "[1]", "{\"event\":1}", "null"] {
            assert_eq!(Line::new(text), Line::Other(text.into()));
        }
    }

    #[test]
    fn nothing_of_a_stranger_moves_the_cursor() {
        let told = told(r#"{"time":"t","event":"warning","reason":"a\u001b[2J\nb","level":1}"#);
        let reason = "a\\u001b[2J b".into();
        assert_eq!(told.what, What::Warning { reason });
        let Line::Other(text) = Line::new("\u{1b}[2Jb") else {
            panic!("no event");
        };
        assert_eq!(text, "\\u001b[2Jb");
    }
}
