use mlr_filter::SettingError;
use serde::{Deserialize, Serialize};

use super::IdentifySettings;

/// How it is known when the walk started.
///
/// ```
/// use mlr_ga::{IdentifySettings, WalkStart};
///
/// let read = |text| toml::from_str::<IdentifySettings>(text).map(|read| read.walk_start);
/// assert_eq!(read("")?, WalkStart::FoundInRecording);
/// assert_eq!(read("walk_start = 'found_in_recording'")?, WalkStart::FoundInRecording);
/// assert_eq!(read("walk_start = { commanded_at_s = 2.0 }")?, WalkStart::CommandedAtS(2.0));
/// assert_eq!(read("walk_start = { observed_at_s = 2.1 }")?, WalkStart::ObservedAtS(2.1));
/// # Ok::<(), toml::de::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum WalkStart {
    /// It is not known: it is the first lasting motion in the recording.
    #[default]
    FoundInRecording,
    /// The controller commanded the walk at this log time. Delays of servos and sensor show
    /// against it.
    CommandedAtS(f64),
    /// The standing robot was seen to start walking at this log time, for instance by a
    /// monitor of the stream that the recording was cut from.
    ObservedAtS(f64),
}

impl WalkStart {
    /// The log time of the start, unless it is to be found in the recording.
    pub fn time_s(self) -> Option<f64> {
        match self {
            Self::FoundInRecording => None,
            Self::CommandedAtS(time_s) | Self::ObservedAtS(time_s) => Some(time_s),
        }
    }

    /// Whether it is known when the controller commanded the walk.
    pub fn is_commanded(self) -> bool {
        matches!(self, Self::CommandedAtS(_))
    }

    pub(super) fn check(self) -> Result<(), SettingError> {
        let (name, time_s) = match self {
            Self::FoundInRecording => return Ok(()),
            Self::CommandedAtS(time_s) => ("walk_start.commanded_at_s", time_s),
            Self::ObservedAtS(time_s) => ("walk_start.observed_at_s", time_s),
        };
        SettingError::check(name, time_s, IdentifySettings::LOG_TIMES_S, "s")
    }
}
