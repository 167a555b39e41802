//! Everything about the daemon that can be chosen: one type for the
//! configuration file and the command line.

use std::{
    path::{Path, PathBuf},
    thread,
};

use anyhow::{Context, bail};
use clap::ValueEnum;
use mlr_filter::SettingError;
use mlr_ga::{
    Configuration, ConfigurationError, IdentifySettings, LARGEST_SEED, Method, checked_toml,
    most_threads,
};
use mlr_imu::{FullScale, MAX_TEXT_BYTES, Mounting, read_text};
use mlr_model::{Gait, JointCommands, Robot};
use mlr_recover::RecoverSettings;
use mlr_residual::walk::EvidenceSettings;
use serde::{Deserialize, Serialize};

use crate::{
    learning::LearningSettings,
    source::{I2cBus, SerialLine, Source, StandardInput},
};

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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Serial port of the IMU, as in /dev/ttyTHS1. Either this or `i2c` or `stdin`.
    pub port: Option<String>,
    /// I²C bus of the MPU6050, as in /dev/i2c-1.
    pub i2c: Option<PathBuf>,
    /// Whether another program hands on samples as lines of text.
    pub stdin: bool,
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
    /// Threads for identifications, explanations and recovery gaits; all cores but one unless told.
    pub threads: Option<usize>,
    /// Seed of the genetic algorithm.
    pub seed: u64,
    /// Whether walks that were identified are explained, at the lowest priority.
    pub explain: bool,
    /// Whether a recovery gait is offered for damage that was identified, at the lowest priority.
    pub recover: bool,
    /// Whether the robot's own parameters are learned from healthy walks, at the lowest priority.
    pub learn: bool,
    /// Robot description in TOML, instead of the embedded JetHexa.
    pub robot: Option<PathBuf>,
    /// Gait in TOML, instead of the embedded tripod.
    pub gait: Option<PathBuf>,
    /// Time between two `status` events.
    pub status_every_s: f64,
    /// Recording of what the sensor says.
    pub record: RecordSettings,
    /// Learning.
    pub learning: LearningSettings,
    /// Ranges of the MPU6050.
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

/// Recording of what the sensor says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct RecordSettings {
    /// Directory for the recordings; none are made without one.
    pub dir: Option<PathBuf>,
    /// How they are written.
    pub format: RecordFormat,
    /// A recording that has reached this size is closed and the next one begun.
    pub file_mb: f64,
    /// All recordings in the directory together stay below this size: the oldest
    /// are removed, which is told each time.
    pub total_mb: f64,
}

/// How recordings are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum RecordFormat {
    /// Text.
    Csv,
    /// MCAP with `sensor_msgs/msg/Imu` of ROS 2, four times as large.
    Mcap,
}

impl Default for RecordSettings {
    fn default() -> Self {
        Self {
            dir: None,
            format: RecordFormat::Csv,
            file_mb: 32.0,
            total_mb: 512.0,
        }
    }
}

impl RecordSettings {
    fn check(&self) -> Result<(), SettingError> {
        SettingError::check("file_mb", self.file_mb, 0.01..=1e6, "MB")?;
        SettingError::check("total_mb", self.total_mb, 0.01..=1e9, "MB")?;
        if self.total_mb < self.file_mb {
            let expected = format!("at least file_mb, {} MB", self.file_mb);
            return Err(SettingError::new("total_mb", self.total_mb, expected));
        }
        Ok(())
    }
}

/// A framing, or recognise it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
    /// Lines of text, on standard input only.
    #[serde(skip)]
    #[value(skip)]
    Lines,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            port: None,
            i2c: None,
            stdin: false,
            i2c_rate_hz: 200.0,
            baud: 115_200,
            format: FramingName::Auto,
            state_dir: None,
            atlas: None,
            threads: None,
            seed: 1,
            explain: true,
            recover: true,
            learn: true,
            robot: None,
            gait: None,
            status_every_s: 10.0,
            record: RecordSettings::default(),
            learning: LearningSettings::default(),
            full_scale: FullScale::default(),
            mounting: Mounting::default(),
            identification: IdentifySettings::default(),
            explanation: EvidenceSettings::default(),
            recovery: RecoverSettings::default(),
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

    /// Reads and checks settings. The identification's are laid over the preset of the
    /// `method`, or of the one that the file names.
    ///
    /// # Errors
    /// [`ConfigurationError`] names the line, and the key as the file spells it.
    pub fn checked_from_toml(
        text: &str,
        method: Option<Method>,
    ) -> Result<Self, ConfigurationError> {
        let settings: Self = checked_toml(text, Self::check)?;
        let shared = Configuration::from_toml_for(text, method)?;
        Ok(Self {
            identification: shared.identification,
            ..settings
        })
    }

    /// Threads for identifications, explanations and recovery gaits.
    pub(crate) fn answer_threads(&self) -> usize {
        self.threads.unwrap_or_else(|| {
            thread::available_parallelism().map_or(1, |cores| (cores.get() - 1).max(1))
        })
    }

    /// Whether walks are explained: effects are weighed by probabilities, which the paper's
    /// method does not have.
    pub(crate) fn explains(&self) -> bool {
        self.explain && self.identification.method == Method::Mlr
    }

    /// Where recovery gaits are written, if they are offered: from probabilities as well.
    pub(crate) fn recovery_dir(&self) -> Option<&Path> {
        let recovers = self.recover && self.identification.method == Method::Mlr;
        self.state_dir.as_deref().filter(|_| recovers)
    }

    /// How healthy walks are learned from, if they are: by probabilities as well.
    pub(crate) fn learning(&self) -> Option<LearningSettings> {
        let learns = self.learn && self.identification.method == Method::Mlr;
        learns.then_some(self.learning)
    }

    /// Checks every number and path. Whether there is a sensor is another question: the
    /// command line may name it.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        for (name, path) in [
            ("port", self.port.as_ref().map(Path::new)),
            ("i2c", self.i2c.as_deref()),
            ("state_dir", self.state_dir.as_deref()),
            ("atlas", self.atlas.as_deref()),
            ("robot", self.robot.as_deref()),
            ("gait", self.gait.as_deref()),
            ("record.dir", self.record.dir.as_deref()),
        ] {
            if path.is_some_and(|path| path.as_os_str().is_empty()) {
                return Err(SettingError::new(name, "\"\"", "a path"));
            }
        }
        self.shared().check()?;
        // What is read more slowly than the identification allows is of no use.
        let slowest_hz = self.identification.sampling.min_rate_hz.min(1000.0);
        SettingError::check("i2c_rate_hz", self.i2c_rate_hz, slowest_hz..=1000.0, "Hz")?;
        SettingError::check("baud", self.baud, 1200..=12_000_000, "baud")?;
        if let Some(threads) = self.threads {
            let most = most_threads();
            SettingError::check("threads", threads, 1..=most, "threads on this machine")?;
        }
        SettingError::check("seed", self.seed, 0..=LARGEST_SEED, "")?;
        let status_every_s = self.status_every_s;
        SettingError::check("status_every_s", status_every_s, 0.1..=86_400.0, "s")?;
        let learning = self.learning.check(match self.learn {
            true => self.identification.window_s,
            false => 0.0,
        });
        learning.map_err(|error| error.under("learning"))?;
        self.record.check().map_err(|error| error.under("record"))
    }

    /// What `mlr-ga --config` reads of the same file.
    fn shared(&self) -> Configuration {
        Configuration {
            full_scale: self.full_scale,
            mounting: self.mounting,
            identification: self.identification.clone(),
            explanation: self.explanation.clone(),
            recovery: self.recovery,
        }
    }

    /// Where the bytes come from.
    pub(crate) fn source(&self) -> anyhow::Result<Box<dyn Source>> {
        match (&self.port, &self.i2c, self.stdin) {
            (Some(device), None, false) => Ok(Box::new(SerialLine {
                device: device.clone(),
                baud: self.baud,
            })),
            (None, Some(device), false) => Ok(Box::new(I2cBus {
                device: device.clone(),
                rate_hz: self.i2c_rate_hz,
                scale: self.full_scale,
            })),
            (None, None, true) => Ok(Box::new(StandardInput)),
            (None, None, false) => bail!("no sensor: expected port, i2c or stdin"),
            _ => bail!("more than one of port, i2c and stdin is given, expected one of them"),
        }
    }

    /// The framing that the source speaks.
    pub(crate) fn framing(&self) -> FramingName {
        if self.stdin {
            FramingName::Lines
        } else if self.i2c.is_some() {
            FramingName::Mlr
        } else {
            self.format
        }
    }

    /// The robot's description, robot and gait, which fit together and to the faults of the
    /// simulation.
    pub(crate) fn model(&self) -> anyhow::Result<(String, Robot, Gait)> {
        let ((description, robot), gait) = (robot(self.robot.as_deref())?, self.gait()?);
        JointCommands::new(&robot, &gait, gait.first_pass_s()).context("robot and gait")?;
        let identification = self.identification.check_on(&robot);
        identification.map_err(|error| error.under("identification"))?;
        Ok((description, robot, gait))
    }

    fn gait(&self) -> anyhow::Result<Gait> {
        let Some(path) = &self.gait else {
            return Ok(Gait::tripod());
        };
        let name = || path.display().to_string();
        let text = read_text(path, Gait::MOST_FILE_BYTES).with_context(name)?;
        Gait::from_toml(&text).with_context(name)
    }
}

/// The description and the robot of a file, or the embedded one.
pub(crate) fn robot(path: Option<&Path>) -> anyhow::Result<(String, Robot)> {
    let Some(path) = path else {
        return Ok((Robot::JETHEXA_TOML.into(), Robot::jethexa()));
    };
    let name = || path.display().to_string();
    let text = read_text(path, MAX_TEXT_BYTES).with_context(name)?;
    let robot = Robot::from_toml(&text).with_context(name)?;
    Ok((text, robot))
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
            "[explanation]\nmost_effect = 1",
        ] {
            let key = text.rsplit('\n').next().unwrap().split(' ').next().unwrap();
            let error = Settings::from_toml(text).unwrap_err().to_string();
            assert!(error.contains(key) && error.contains("line"), "{error}");
        }
    }

    #[test]
    fn bounds_that_depend_on_each_other_or_the_machine_are_kept() {
        let message = |text| {
            Settings::checked_from_toml(text, None)
                .unwrap_err()
                .to_string()
        };
        assert!(message("[record]\ntotal_mb = 1.0").starts_with("line 2: record.total_mb: 1"));
        assert!(message("i2c_rate_hz = 30.0").contains("45 to 1000 Hz"));
        assert!(message("threads = 100000").contains("on this machine"));
        assert!(message("port = ''").contains("port: \"\" is not valid, expected a path"));
        assert!(Settings::default().source().is_err(), "no sensor is named");
    }

    #[test]
    fn a_gait_that_the_robot_cannot_follow_is_refused_at_the_start() {
        let folder = tempfile::tempdir().unwrap();
        let gait = folder.path().join("gait.toml");
        std::fs::write(&gait, Gait::TRIPOD_TOML.replace("0.060", "0.5")).unwrap();
        let far = Settings {
            gait: Some(gait),
            ..Settings::default()
        };
        let message = format!("{:#}", far.model().unwrap_err());
        assert!(message.contains("cannot reach"), "{message}");
        Settings::default().model().unwrap();
    }

    #[test]
    fn the_shipped_configuration_shows_the_defaults() {
        let shipped = include_str!("../systemd/mlrd.toml");
        // What has no default is shown as an example.
        let examples = [
            "i2c",
            "state_dir",
            "atlas",
            "threads",
            "robot",
            "gait",
            "dir",
        ];
        let is_key = |text: &str| text.chars().all(|c| c.is_alphanumeric() || c == '_');
        let lines = shipped.lines().filter_map(|line| {
            let shown = line.strip_prefix("# ").unwrap_or(line);
            match shown.split_once(" = ") {
                Some((key, _)) if examples.contains(&key) => None,
                Some((key, _)) if is_key(key) => Some(shown),
                _ => Some(line),
            }
        });
        let text: Vec<&str> = lines.collect();
        let defaults = Settings {
            port: Some("/dev/ttyTHS1".into()),
            ..Settings::default()
        };
        assert_eq!(
            Settings::checked_from_toml(&text.join("\n"), None).unwrap(),
            defaults
        );
    }

    #[test]
    fn the_command_line_reads_the_same_file() {
        let text = include_str!("../systemd/mlrd.toml");
        assert_eq!(
            Configuration::from_toml(text).unwrap(),
            Settings::from_toml(text).unwrap().shared()
        );
        // Every key, alone: the daemon's own are known, the others are shared.
        let complete = Settings {
            port: Some("/dev/ttyTHS1".into()),
            i2c: Some("/dev/i2c-1".into()),
            state_dir: Some("/var/lib/mlrd".into()),
            atlas: Some("jethexa.atlas".into()),
            threads: Some(1),
            robot: Some("robot.toml".into()),
            gait: Some("gait.toml".into()),
            ..Settings::default()
        };
        let all = toml::Table::try_from(complete).unwrap();
        assert!(all.contains_key("gait") && all.contains_key("explanation"));
        for (key, value) in all {
            let alone = toml::Table::from_iter([(key, value)]).to_string();
            Configuration::from_toml(&alone).unwrap();
        }
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
