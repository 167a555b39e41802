//! Everything about the daemon that can be chosen: one type for the
//! configuration file and the command line.

use std::path::PathBuf;

use anyhow::{Context, bail, ensure};
use clap::ValueEnum;
use mlr_ga::IdentifySettings;
use mlr_imu::{FullScale, MAX_TEXT_BYTES, Mounting, read_text};
use mlr_model::{Gait, Robot};
use mlr_residual::walk::TracingSettings;
use serde::{Deserialize, Serialize};

use crate::source::{I2cBus, SerialLine, Source};

/// The daemon's settings, as in `/etc/mlrd.toml`.
///
/// ```
/// let settings = mlrd::Settings::from_toml("port = '/dev/ttyTHS1'\nbaud = 460800")?;
/// assert_eq!(settings.baud, 460_800);
/// let error = mlrd::Settings::from_toml("bauds = 9600").unwrap_err();
/// assert!(error.to_string().contains("bauds"));
/// # Ok::<(), toml::de::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Serial port of the IMU, as in /dev/ttyTHS1. Either this or `i2c`.
    pub port: Option<String>,
    /// I²C bus of the MPU6050, as in /dev/i2c-1.
    pub i2c: Option<PathBuf>,
    /// How often the MPU6050 on the I²C bus is read.
    pub i2c_rate_hz: f64,
    /// Speed of the port.
    pub baud: u32,
    /// Framing of the bytes.
    pub format: FramingName,
    /// Directory for what the daemon remembers beyond its end.
    pub state_dir: Option<PathBuf>,
    /// Walks simulated beforehand by `mlr-ga atlas build`, for instant answers.
    pub atlas: Option<PathBuf>,
    /// Threads for identification; all cores but one unless told.
    pub threads: Option<usize>,
    /// Seed of the genetic algorithm.
    pub seed: u64,
    /// Whether walks that were identified are explained, at the lowest priority.
    pub explain: bool,
    /// Robot description in TOML, instead of the embedded JetHexa.
    pub robot: Option<PathBuf>,
    /// Gait in TOML, instead of the embedded tripod.
    pub gait: Option<PathBuf>,
    /// Time between two `status` events.
    pub status_every_s: f64,
    /// Recording of what the sensor says.
    pub record: RecordSettings,
    /// Ranges of the MPU6050.
    pub full_scale: FullScale,
    /// How the sensor sits on the body.
    pub mounting: Mounting,
    /// Detection and identification.
    pub identification: IdentifySettings,
    /// Explanation.
    pub tracing: TracingSettings,
}

/// Recording of what the sensor says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RecordSettings {
    /// Directory for the recordings; none are made without one.
    pub dir: Option<PathBuf>,
    /// A recording that has reached this size is closed and the next one begun.
    pub file_mb: f64,
    /// All recordings in the directory together stay below this size: the oldest
    /// are removed, which is told each time.
    pub total_mb: f64,
}

impl Default for RecordSettings {
    fn default() -> Self {
        Self {
            dir: None,
            file_mb: 32.0,
            total_mb: 512.0,
        }
    }
}

/// A framing, or recognise it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FramingName {
    /// Whichever the line carries.
    Auto,
    /// i2cdevlib's teapot packets.
    Teapot,
    /// WitMotion modules.
    Witmotion,
    /// A bridge of one's own.
    Mlr,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            port: None,
            i2c: None,
            i2c_rate_hz: 200.0,
            baud: 115_200,
            format: FramingName::Auto,
            state_dir: None,
            atlas: None,
            threads: None,
            seed: 1,
            explain: true,
            robot: None,
            gait: None,
            status_every_s: 10.0,
            record: RecordSettings::default(),
            full_scale: FullScale::default(),
            mounting: Mounting::default(),
            identification: IdentifySettings::default(),
            tracing: TracingSettings::default(),
        }
    }
}

impl Settings {
    /// Reads settings; what is not named keeps its default.
    ///
    /// # Errors
    /// Names line and column, and an unknown key by its name.
    pub fn from_toml(text: &str) -> Result<Self, toml::de::Error> {
        toml::from_str(text)
    }

    /// Checks what no other part checks before the first bytes arrive.
    pub(crate) fn check(&self) -> anyhow::Result<()> {
        for (name, value, low, high) in [
            ("i2c_rate_hz", self.i2c_rate_hz, 20.0, 1000.0),
            ("status_every_s", self.status_every_s, 0.1, 86_400.0),
            ("record.file_mb", self.record.file_mb, 0.01, 1e6),
            ("record.total_mb", self.record.total_mb, 0.01, 1e9),
            ("tracing.least_gain", self.tracing.least_gain, 0.0, 1e6),
            (
                "tracing.price_per_parameter",
                self.tracing.price_per_parameter,
                0.0,
                1e6,
            ),
            ("tracing.rival_gain", self.tracing.rival_gain, 0.0, 1e6),
            ("tracing.switch_gain", self.tracing.switch_gain, 0.0, 1e6),
        ] {
            let valid = (low..=high).contains(&value);
            ensure!(
                valid,
                "{name}: {value} is not valid, expected {low} to {high}"
            );
        }
        ensure!(
            self.record.total_mb >= self.record.file_mb,
            "record.total_mb: {} is not valid, expected at least record.file_mb",
            self.record.total_mb
        );
        ensure!(
            self.threads != Some(0),
            "threads: 0 is not valid, expected at least 1"
        );
        self.mounting.check()?;
        Ok(())
    }

    /// Where the bytes come from.
    pub(crate) fn source(&self) -> anyhow::Result<Box<dyn Source>> {
        match (&self.port, &self.i2c) {
            (Some(device), None) => Ok(Box::new(SerialLine {
                device: device.clone(),
                baud: self.baud,
            })),
            (None, Some(device)) => Ok(Box::new(I2cBus {
                device: device.clone(),
                rate_hz: self.i2c_rate_hz,
                scale: self.full_scale,
            })),
            (None, None) => bail!("no sensor: expected port or i2c"),
            (Some(_), Some(_)) => bail!("both port and i2c are given, expected one of them"),
        }
    }

    /// The framing that the source speaks.
    pub(crate) fn framing(&self) -> FramingName {
        if self.i2c.is_some() {
            FramingName::Mlr
        } else {
            self.format
        }
    }

    pub(crate) fn robot(&self) -> anyhow::Result<Robot> {
        let Some(path) = &self.robot else {
            return Ok(Robot::jethexa());
        };
        let name = || path.display().to_string();
        let text = read_text(path, MAX_TEXT_BYTES).with_context(name)?;
        Robot::from_toml(&text).with_context(name)
    }

    pub(crate) fn gait(&self) -> anyhow::Result<Gait> {
        let Some(path) = &self.gait else {
            return Ok(Gait::tripod());
        };
        let name = || path.display().to_string();
        let text = read_text(path, MAX_TEXT_BYTES).with_context(name)?;
        Gait::from_toml(&text).with_context(name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_survive_being_written_down() {
        let settings = Settings {
            port: Some("/dev/ttyUSB0".into()),
            threads: Some(2),
            ..Settings::default()
        };
        let text = toml::to_string(&settings).unwrap();
        assert_eq!(Settings::from_toml(&text).unwrap(), settings);
    }

    #[test]
    fn unknown_keys_are_refused_by_name_at_every_level() {
        for text in [
            "speed = 9600",
            "[mounting]\nyaw = 3.0",
            "[record]\nsize = 1",
            "[identification.detector]\ntreshold_deg = 5.0",
            "[tracing]\nmost_effect = 1",
        ] {
            let key = text.rsplit('\n').next().unwrap().split(' ').next().unwrap();
            let error = Settings::from_toml(text).unwrap_err().to_string();
            assert!(error.contains(key) && error.contains("line"), "{error}");
        }
    }

    #[test]
    fn values_that_make_no_sense_are_refused() {
        let mut settings = Settings {
            i2c_rate_hz: f64::NAN,
            ..Settings::default()
        };
        assert!(settings.check().is_err());
        settings = Settings::default();
        settings.record.total_mb = 1.0;
        assert!(
            settings
                .check()
                .unwrap_err()
                .to_string()
                .contains("record.total_mb")
        );
        settings = Settings::default();
        settings.tracing.least_gain = f64::NAN;
        assert!(settings.check().is_err());
        assert!(Settings::default().source().is_err(), "no sensor is named");
    }

    #[test]
    fn the_shipped_configuration_is_valid_and_shows_every_option() {
        let text = include_str!("../systemd/mlrd.toml");
        let shipped = Settings::from_toml(text).unwrap();
        shipped.check().unwrap();
        let all = toml::Table::try_from(Settings::default()).unwrap();
        for key in all.keys() {
            assert!(text.contains(key.as_str()), "{key} is not shown");
        }
    }
}
