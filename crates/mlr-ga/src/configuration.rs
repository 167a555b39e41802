//! The configuration file that the command line and the daemon share.

use std::thread;

use mlr_filter::SettingError;
use mlr_imu::{FullScale, Mounting};
use mlr_model::located;
use mlr_recover::RecoverSettings;
use mlr_residual::walk::EvidenceSettings;
use serde::{
    Deserialize, Serialize,
    de::{DeserializeOwned, IgnoredAny},
};
use thiserror::Error;

use crate::{IdentifySettings, Method};

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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Configuration {
    /// Ranges of the MPU6050 that raw counts come from.
    pub full_scale: FullScale,
    /// How the sensor sits on the body.
    pub mounting: Mounting,
    /// Detection and identification.
    pub identification: IdentifySettings,
    /// Explanation.
    pub explanation: EvidenceSettings,
    /// Search for a recovery gait.
    pub recovery: RecoverSettings,
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
    /// keeps its default, which for the identification is the preset of its method.
    ///
    /// # Errors
    /// [`ConfigurationError`] names the line, and the key as the file spells it.
    pub fn from_toml(text: &str) -> Result<Self, ConfigurationError> {
        Self::from_toml_for(text, None)
    }

    /// The same with another method than the one that the file names.
    ///
    /// # Errors
    /// [`ConfigurationError`] names the line, and the key as the file spells it.
    pub fn from_toml_for(text: &str, method: Option<Method>) -> Result<Self, ConfigurationError> {
        let mut keys: toml::Table = toml::from_str(text)?;
        let is_sectioned = keys
            .keys()
            .any(|key| Sections::KEYS.contains(&key.as_str()));
        let mut read: Self = if is_sectioned {
            toml::from_str::<Sections>(text)?.into()
        } else {
            Self {
                identification: toml::from_str(text)?,
                ..Self::default()
            }
        };
        let named = match is_sectioned {
            true => keys.remove("identification"),
            false => Some(toml::Value::Table(keys)),
        };
        read.identification = over_preset(
            method.unwrap_or(read.identification.method),
            named.unwrap_or_else(|| toml::Table::new().into()),
        )?;
        let checked = match is_sectioned {
            true => read.check(),
            false => read.identification.check(),
        };
        checked.map_err(|error| located(error, text))?;
        Ok(read)
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        for (section, checked) in [
            ("mounting", self.mounting.check()),
            ("identification", self.identification.check()),
            ("explanation", self.explanation.check()),
            ("recovery", self.recovery.check()),
        ] {
            checked.map_err(|error| error.under(section))?;
        }
        Ok(())
    }
}

/// The settings that a file names, over the preset of the method.
fn over_preset(method: Method, named: toml::Value) -> Result<IdentifySettings, ConfigurationError> {
    let mut settings =
        toml::Value::try_from(IdentifySettings::of(method)).expect("settings have a form in TOML");
    lay_over(&mut settings, named);
    let settings: IdentifySettings = settings.try_into()?;
    Ok(IdentifySettings { method, ..settings })
}

/// Replaces the values that `named` has, table by table.
fn lay_over(settings: &mut toml::Value, named: toml::Value) {
    match (settings, named) {
        (toml::Value::Table(settings), toml::Value::Table(named)) => {
            for (key, value) in named {
                match settings.get_mut(&key) {
                    Some(known) => lay_over(known, value),
                    None => {
                        settings.insert(key, value);
                    }
                }
            }
        }
        (settings, named) => *settings = named,
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
            explanation: EvidenceSettings,
            recovery: RecoverSettings,
            $($daemons: IgnoredAny,)+
        }

        impl Sections {
            const KEYS: &[&str] = &[
                "full_scale", "mounting", "identification", "explanation", "recovery",
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
    stdin,
    baud,
    format,
    state_dir,
    atlas,
    threads,
    seed,
    explain,
    recover,
    learn,
    learning,
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
            explanation,
            recovery,
            ..
        } = sections;
        Self {
            full_scale,
            mounting,
            identification,
            explanation,
            recovery,
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
                    [mounting]\nyaw_deg = 90.0\n[explanation.effort]\nmost_effects = 1\n\
                    [full_scale]\ngyroscope = 'dps500'\n[identification.detector]\nstep_s = 0.05";
        let read = Configuration::from_toml(text).unwrap();
        assert_eq!(read.mounting.yaw_deg, 90.0);
        assert_eq!(read.explanation.effort.most_effects, 1);
        assert_eq!(read.identification.detector.step_s, 0.05);
        assert_ne!(read.full_scale, FullScale::default());
    }

    #[test]
    fn a_method_brings_its_preset_and_the_file_has_the_last_word() {
        let paper = IdentifySettings::of(Method::Paper);
        let read = |text| Configuration::from_toml(text).unwrap().identification;
        assert_eq!(read("method = 'paper'"), paper);
        assert_eq!(read("[identification]\nmethod = 'paper'"), paper);
        let changed = read("method = 'paper'\n[genetic]\ngenerations = 40");
        assert_eq!(changed.genetic.generations, 40);
        assert_eq!(changed.genetic.islands, paper.genetic.islands);
        let asked = Configuration::from_toml_for("window_s = 4.0", Some(Method::Paper)).unwrap();
        assert_eq!(
            asked.identification,
            IdentifySettings {
                window_s: 4.0,
                ..paper
            }
        );
        assert_eq!(read("window_s = 5.0"), IdentifySettings::default());
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
            "[explanation.prior]\nany = -1",
            "line 2: explanation.prior.any: -1",
        );
    }
}
