//! The configuration file that the command line and the daemon share.

use std::thread;

use mlr_filter::SettingError;
use mlr_imu::{FullScale, Mounting};
use mlr_model::located;
use mlr_residual::walk::TracingSettings;
use serde::{
    Deserialize, Serialize,
    de::{DeserializeOwned, IgnoredAny},
};
use thiserror::Error;

use crate::IdentifySettings;

/// The settings that the command line and the daemon share, each part a section of the file.
///
/// ```
/// use mlr_ga::Configuration;
///
/// // The daemon's own keys are its own.
/// let file = "port = '/dev/ttyTHS1'\n[identification]\nwindow_s = 4.0";
/// assert_eq!(Configuration::from_toml(file)?.identification.window_s, 4.0);
/// // A file of the identification's settings alone needs no section.
/// assert_eq!(Configuration::from_toml("window_s = 4.0")?.identification.window_s, 4.0);
/// let error = Configuration::from_toml("[identification]\nwindow_s = 0").unwrap_err();
/// assert_eq!(
///     error.to_string(),
///     "line 2: identification.window_s: 0 is not valid, expected 0.5 to 600 s"
/// );
/// # Ok::<(), mlr_ga::ConfigurationError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Configuration {
    /// Ranges of the MPU6050 that raw counts come from.
    pub full_scale: FullScale,
    /// How the sensor sits on the body.
    pub mounting: Mounting,
    /// Detection and identification.
    pub identification: IdentifySettings,
    /// Explanation.
    pub tracing: TracingSettings,
}

/// What is wrong with a configuration file.
#[derive(Debug, Error)]
pub enum ConfigurationError {
    /// It is not TOML of the expected form. Names line, column and the key.
    #[error(transparent)]
    Syntax(#[from] toml::de::Error),
    /// A value makes no sense.
    #[error(transparent)]
    Setting(#[from] SettingError),
}

impl Configuration {
    /// Reads and checks a configuration: a file with sections, such as the daemon's, whose
    /// own keys are skipped; or the settings of the identification alone. What is not named
    /// keeps its default.
    ///
    /// # Errors
    /// [`ConfigurationError`] names the line, and the key as the file spells it.
    pub fn from_toml(text: &str) -> Result<Self, ConfigurationError> {
        let keys: toml::Table = toml::from_str(text)?;
        if keys
            .keys()
            .any(|key| Sections::KEYS.contains(&key.as_str()))
        {
            let configuration: Self = toml::from_str::<Sections>(text)?.into();
            configuration
                .check()
                .map_err(|error| located(error, text))?;
            return Ok(configuration);
        }
        Ok(Self {
            identification: checked_toml(text, IdentifySettings::check)?,
            ..Self::default()
        })
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        for (section, checked) in [
            ("mounting", self.mounting.check()),
            ("identification", self.identification.check()),
            ("tracing", self.tracing.check()),
        ] {
            checked.map_err(|error| error.under(section))?;
        }
        Ok(())
    }
}

/// Settings in TOML, checked.
///
/// # Errors
/// [`ConfigurationError`] names the line, and the key as the file spells it.
pub fn checked_toml<S: DeserializeOwned>(
    text: &str,
    check: impl Fn(&S) -> Result<(), SettingError>,
) -> Result<S, ConfigurationError> {
    let settings: S = toml::from_str(text)?;
    check(&settings).map_err(|error| located(error, text))?;
    Ok(settings)
}

/// The largest seed: larger whole numbers do not survive JSON.
pub const LARGEST_SEED: u64 = (1 << 53) - 1;

/// Upper bound of a program's option for threads: four for each core.
pub fn most_threads() -> usize {
    4 * thread::available_parallelism().map_or(1, |cores| cores.get())
}

macro_rules! sections {
    ($($daemons:ident),+ $(,)?) => {
        /// The form of the file with sections.
        #[derive(Default, Deserialize)]
        #[serde(deny_unknown_fields, default)]
        struct Sections {
            full_scale: FullScale,
            mounting: Mounting,
            identification: IdentifySettings,
            tracing: TracingSettings,
            $($daemons: IgnoredAny,)+
        }

        impl Sections {
            const KEYS: &[&str] = &[
                "full_scale", "mounting", "identification", "tracing",
                $(stringify!($daemons)),+
            ];
        }
    };
}

// The keys that only the daemon reads. A test of the daemon compares them with its own.
sections![
    port,
    i2c,
    i2c_rate_hz,
    baud,
    format,
    state_dir,
    atlas,
    threads,
    seed,
    explain,
    robot,
    gait,
    status_every_s,
    record,
];

impl From<Sections> for Configuration {
    fn from(sections: Sections) -> Self {
        let Sections {
            full_scale,
            mounting,
            identification,
            tracing,
            ..
        } = sections;
        Self {
            full_scale,
            mounting,
            identification,
            tracing,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        Configuration::from_toml(text).unwrap_err().to_string()
    }

    #[test]
    fn the_sections_of_the_daemons_file_are_read_and_its_own_keys_skipped() {
        let text = "port = '/dev/ttyTHS1'\nbaud = 460800\n[record]\ndir = '/var/lib'\n\
                    [mounting]\nyaw_deg = 90.0\n[tracing]\nmost_effects = 1\n\
                    [full_scale]\ngyroscope = 'dps500'\n[identification.detector]\nstep_s = 0.05";
        let read = Configuration::from_toml(text).unwrap();
        assert_eq!(read.mounting.yaw_deg, 90.0);
        assert_eq!(read.tracing.most_effects, 1);
        assert_eq!(read.identification.detector.step_s, 0.05);
        assert_ne!(read.full_scale, FullScale::default());
    }

    #[test]
    fn misspelt_keys_are_named_in_either_form() {
        for (text, key, line) in [
            ("port = 'x'\nbauds = 9600", "bauds", "line 2"),
            ("[identificaton]\nwindow_s = 5", "identificaton", "line 1"),
            ("windw_s = 5", "windw_s", "line 1"),
            ("[mounting]\nyaw = 3.0", "yaw", "line 2"),
            ("[detector]\nwindw_s = 3.0", "windw_s", "line 2"),
        ] {
            let message = message(text);
            assert!(message.contains(key) && message.contains(line), "{message}");
        }
    }

    #[test]
    fn values_are_named_as_the_file_spells_them() {
        let starts = |text, start: &str| {
            let message = message(text);
            assert!(message.starts_with(start), "{message}");
        };
        starts("[detector]\nwindow_s = 0", "line 2: detector.window_s: 0");
        starts(
            "[identification.detector]\nwindow_s = 0",
            "line 2: identification.detector.window_s: 0",
        );
        starts(
            "[mounting]\n\nyaw_deg = nan",
            "line 3: mounting.yaw_deg: NaN",
        );
        starts(
            "[tracing]\nleast_gain = -1",
            "line 2: tracing.least_gain: -1",
        );
    }
}
