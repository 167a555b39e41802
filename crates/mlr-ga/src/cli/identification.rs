//! Which robot is identified from which logs, and how.

use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use clap::{Args, ValueEnum};
use mlr_filter::SettingError;
use mlr_ga::{
    Configuration, IdentificationReport, IdentifyOverrides, IdentifySettings, LossHypothesis,
    Method, identify_together,
};
use mlr_imu::{Mounting, Recording};
use mlr_model::{Gait, Robot};

use super::{
    atlas_files::AtlasFiles,
    log_file::LogFiles,
    model_files::{MethodName, ModelOfLogs},
    output,
    progress::Bar,
    search_options::SearchOptions,
};

/// The options of an identification.
#[derive(Debug, Args)]
pub(super) struct IdentificationOptions {
    #[command(flatten)]
    logs: LogFiles,
    #[command(flatten)]
    search: SearchOptions,
    /// What decides [default: mlr].
    #[arg(long, value_enum)]
    method: Option<MethodName>,
    /// Run the genetic algorithm N times, and report how often it found which morphology [default:
    /// 1; 10 with --method paper].
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    repeats: Option<usize>,
    /// Length of the compared stretch [default: 5 s].
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    window_s: Option<f64>,
    /// Log time at which the compared stretch begins [default: the start of the walk, or when damage
    /// is flagged in mid-walk]. Of one log only.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    from_s: Option<f64>,
    /// What lost links may have become [default: either].
    #[arg(long, value_enum)]
    lost_links: Option<LossName>,
    /// Friction between feet and ground [default: 0.7].
    #[arg(long, value_name = "MU", allow_negative_numbers = true)]
    friction: Option<f64>,
    /// All settings, in TOML, such as the daemon's /etc/mlrd.toml; options override it.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    #[command(flatten)]
    atlas: AtlasFiles,
    #[command(flatten)]
    model: ModelOfLogs,
}

/// Settings, robot and gaits of an identification.
#[derive(Debug)]
pub(super) struct Asked {
    /// The settings.
    pub(super) settings: IdentifySettings,
    /// How the sensor sits on the robot.
    pub(super) mounting: Mounting,
    /// The robot in full health.
    pub(super) robot: Robot,
    /// The gait of each log.
    pub(super) gaits: Vec<Gait>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum LossName {
    /// Gone.
    Absent,
    /// Locked clear of the ground.
    Locked,
    /// Whichever fits better.
    Either,
}

impl IdentificationOptions {
    /// Settings, robot and gaits as the options name them, checked.
    pub(super) fn asked(&self) -> anyhow::Result<Asked> {
        let Configuration {
            identification,
            mounting,
            ..
        } = Configuration::read(self.config.as_deref(), self.method.map(Method::from))?;
        let settings = self.settings(identification)?;
        let (robot, _, gaits) = self.model.read(self.logs.paths().len())?;
        settings.check_on(&robot)?;
        Ok(Asked {
            settings,
            mounting,
            robot,
            gaits,
        })
    }

    /// The logs.
    pub(super) fn logs(&self) -> &LogFiles {
        &self.logs
    }

    /// The file that describes the robot, if one was named.
    pub(super) fn robot_file(&self) -> Option<&Path> {
        self.model.robot_file()
    }

    /// What the logs recorded.
    pub(super) fn recordings(&self, asked: &Asked) -> anyhow::Result<Vec<Recording>> {
        self.logs.read(&asked.mounting)
    }

    /// Identifies the robot of the logs, and warns of what there is to warn of.
    pub(super) fn answer(
        &self,
        asked: &Asked,
        recordings: &[Recording],
        started: Instant,
    ) -> anyhow::Result<IdentificationReport> {
        let Asked {
            settings,
            robot,
            gaits,
            ..
        } = asked;
        let atlases = self.atlas.open(robot, gaits, settings)?;
        let walks = atlases.walks(recordings, gaits);
        let bar = Bar::new();
        let answer = identify_together(&walks, robot, settings, &bar);
        bar.clear();
        let identification = answer.map_err(|(log, error)| self.logs.blame(log, error))?;
        let files = self.logs.names();
        if files.len() > 1 {
            for (file, log) in files.iter().zip(&identification.logs) {
                for warning in &log.warnings {
                    output::warning(&format!("{file}: {warning}"));
                }
            }
        }
        for warning in &identification.warnings {
            output::warning(warning);
        }
        let elapsed = started.elapsed();
        Ok(IdentificationReport::of_files(
            files,
            identification,
            elapsed,
        ))
    }

    /// The settings of the file, which were checked, with the options in their place.
    fn settings(&self, settings: IdentifySettings) -> Result<IdentifySettings, SettingError> {
        let overrides = IdentifyOverrides {
            repeats: self.repeats,
            window_s: self.window_s,
            from_s: self.from_s,
            lost_links: self.lost_links.map(LossHypothesis::from),
            friction: self.friction,
            ..self.search.overrides()
        };
        overrides.over(settings).map_err(|error| {
            error.as_option(&[
                ("window_s", "--window-s"),
                ("from_s", "--from-s"),
                ("repeats", "--repeats"),
                ("friction", "--friction"),
            ])
        })
    }
}

impl From<LossName> for LossHypothesis {
    fn from(name: LossName) -> Self {
        match name {
            LossName::Absent => Self::Absent,
            LossName::Locked => Self::Locked,
            LossName::Either => Self::Either,
        }
    }
}
