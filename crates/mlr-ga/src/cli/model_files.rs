//! Robot and gait, embedded or from the user's files, their atlas, and settings.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, ValueEnum};
use mlr_ga::{Configuration, IdentifySettings, Method, atlas::Atlas, checked_toml};
use mlr_imu::{MAX_TEXT_BYTES, read_text};
use mlr_model::{Gait, JointCommands, Robot};
use mlr_residual::walk::EvidenceSettings;

use super::resume::checksum_of_file;

/// Replaces the embedded robot and gait.
#[derive(Debug, Args)]
pub(super) struct ModelFiles {
    #[command(flatten)]
    robot: RobotFile,
    /// Gait in TOML, the motion of feet or a joint trajectory; or tripod for the embedded one
    /// [default: tripod].
    #[arg(long, value_name = "FILE")]
    gait: Option<PathBuf>,
}

/// Replaces the embedded robot and the gaits of its logs.
#[derive(Debug, Args)]
pub(super) struct ModelOfLogs {
    #[command(flatten)]
    robot: RobotFile,
    /// Gait in TOML, the motion of feet or a joint trajectory; or tripod for the embedded one: one
    /// for all logs, or one for each in their order [default: tripod].
    #[arg(long, value_name = "FILE")]
    gait: Vec<PathBuf>,
}

/// Replaces the embedded robot.
#[derive(Debug, Args)]
struct RobotFile {
    /// Robot description in TOML [default: the embedded JetHexa].
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
}

/// What stands for the embedded gait among several.
const TRIPOD: &str = "tripod";

impl ModelFiles {
    /// Robot and gait, which fit together.
    pub(super) fn read(&self) -> anyhow::Result<(Robot, Gait)> {
        let (robot, _) = self.robot.read()?;
        let gait = self.robot.gait(&robot, self.gait.as_deref())?;
        Ok((robot, gait))
    }

    /// The robot, where its gait does not matter.
    pub(super) fn robot(&self) -> anyhow::Result<Robot> {
        Ok(self.robot.read()?.0)
    }
}

impl ModelOfLogs {
    /// The file that describes the robot, if one was named.
    pub(super) fn robot_file(&self) -> Option<&Path> {
        self.robot.robot.as_deref()
    }

    /// The robot, the text that describes it, and the gait of each of so many logs.
    pub(super) fn read(&self, logs: usize) -> anyhow::Result<(Robot, String, Vec<Gait>)> {
        let (robot, text) = self.robot.read()?;
        let gaits = self.robot.gaits(&robot, &self.gait, logs)?;
        Ok((robot, text, gaits))
    }
}

/// Each log's own robot, where logs are of several robots.
#[derive(Debug, Args)]
pub(super) struct OwnRobots {
    /// Take the robot of each log from DIR/LOG.toml, as calibrate wrote it.
    #[arg(long, value_name = "DIR", conflicts_with = "robot")]
    own_robots: Option<PathBuf>,
}

impl OwnRobots {
    /// Whether there is a directory of them.
    pub(super) fn are_named(&self) -> bool {
        self.own_robots.is_some()
    }

    /// The own robot of a log, if there is a directory of them.
    pub(super) fn of(&self, log: &str) -> anyhow::Result<Option<Robot>> {
        let path = self.own_robots.as_ref();
        let path = path.map(|directory| directory.join(format!("{log}.toml")));
        load(path.as_deref(), Robot::from_toml)
    }
}

impl RobotFile {
    /// The robot, and the text that describes it.
    fn read(&self) -> anyhow::Result<(Robot, String)> {
        let described = |text: &str| Robot::from_toml(text).map(|robot| (robot, text.to_string()));
        let read = load(self.robot.as_deref(), described)?;
        Ok(read.unwrap_or_else(|| (Robot::jethexa(), Robot::JETHEXA_TOML.into())))
    }

    /// A gait that the robot can follow from its first step until it repeats or ends.
    fn gait(&self, robot: &Robot, file: Option<&Path>) -> anyhow::Result<Gait> {
        let file = file.filter(|file| file.as_os_str() != TRIPOD);
        let gait = load_up_to(Gait::MOST_FILE_BYTES, file, Gait::from_toml)?;
        let gait = gait.unwrap_or_else(Gait::tripod);
        match JointCommands::new(robot, &gait, gait.first_pass_s()) {
            Ok(_) => Ok(gait),
            Err(error) => Err(self.blame(file, error.into())),
        }
    }

    /// The gait of each of so many logs: one for all, or one each in their order.
    fn gaits(&self, robot: &Robot, files: &[PathBuf], logs: usize) -> anyhow::Result<Vec<Gait>> {
        if files.len() > 1 && files.len() != logs {
            anyhow::bail!(
                "{} gaits for {logs} logs, expected one --gait for all logs, or one for each",
                files.len()
            );
        }
        let of = |log: usize| files.get(log).or(files.first()).map(PathBuf::as_path);
        (0..logs).map(|log| self.gait(robot, of(log))).collect()
    }

    /// Names the files in an error that comes from robot and gait.
    fn blame(&self, gait: Option<&Path>, error: anyhow::Error) -> anyhow::Error {
        let files: Vec<String> = [gait, self.robot.as_deref()]
            .into_iter()
            .flatten()
            .map(|path| path.display().to_string())
            .collect();
        error.context(match files.is_empty() {
            true => "the embedded robot and gait".to_string(),
            false => files.join(" with "),
        })
    }
}

/// Walks of the model, simulated beforehand.
#[derive(Debug, Args)]
pub(super) struct AtlasFile {
    /// Walks simulated beforehand by `mlr-ga atlas build`.
    #[arg(long, value_name = "FILE")]
    atlas: Option<PathBuf>,
}

impl AtlasFile {
    /// Whether one was named.
    pub(super) fn is_named(&self) -> bool {
        self.atlas.is_some()
    }

    /// Check sum of the file, if one was named.
    pub(super) fn checksum(&self) -> anyhow::Result<Option<String>> {
        let of =
            |path: &PathBuf| checksum_of_file(path).with_context(|| path.display().to_string());
        self.atlas.as_ref().map(of).transpose()
    }

    /// The atlas, if one was named; it must belong to this robot, gait and settings.
    pub(super) fn open(
        &self,
        robot: &Robot,
        gait: &Gait,
        settings: &IdentifySettings,
    ) -> anyhow::Result<Option<Atlas>> {
        let path = self.atlas.as_ref();
        Ok(path
            .map(|path| Atlas::open(path, robot, gait, settings))
            .transpose()?)
    }
}

/// What decides.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum MethodName {
    /// The most probable morphology, over what a robot may differ by.
    Mlr,
    /// The paper's method as published: the least F that its genetic algorithm finds, most
    /// frequent of ten runs.
    Paper,
}

impl From<MethodName> for Method {
    fn from(name: MethodName) -> Self {
        match name {
            MethodName::Mlr => Self::Mlr,
            MethodName::Paper => Self::Paper,
        }
    }
}

/// All settings, checked, from a file in TOML over the preset of the method; the preset alone
/// where no file is named.
pub(super) fn configuration(
    path: Option<&Path>,
    method: Option<MethodName>,
) -> anyhow::Result<Configuration> {
    let method = method.map(Method::from);
    let read = load(path, |text| Configuration::from_toml_for(text, method))?;
    Ok(read.unwrap_or_else(|| Configuration {
        identification: IdentifySettings::of(method.unwrap_or_default()),
        ..Configuration::default()
    }))
}

/// Settings of the explanation, checked, from a file of their own, if one is named.
pub(super) fn explanation(path: Option<&Path>) -> anyhow::Result<Option<EvidenceSettings>> {
    load(path, |text| checked_toml(text, EvidenceSettings::check))
}

/// Reads and parses a file, if there is one to read; errors name it.
fn load<T, E>(
    path: Option<&Path>,
    parse: impl FnOnce(&str) -> Result<T, E>,
) -> anyhow::Result<Option<T>>
where
    E: std::error::Error + Send + Sync + 'static,
{
    load_up_to(MAX_TEXT_BYTES, path, parse)
}

/// The same for a file that may be so large.
fn load_up_to<T, E>(
    max_bytes: u64,
    path: Option<&Path>,
    parse: impl FnOnce(&str) -> Result<T, E>,
) -> anyhow::Result<Option<T>>
where
    E: std::error::Error + Send + Sync + 'static,
{
    path.map(|path| read_file(max_bytes, path, parse))
        .transpose()
}

/// The gait of a file.
pub(super) fn gait_of(path: &Path) -> anyhow::Result<Gait> {
    read_file(Gait::MOST_FILE_BYTES, path, Gait::from_toml)
}

/// Reads a file that is no larger than that.
fn read_file<T, E>(
    max_bytes: u64,
    path: &Path,
    parse: impl FnOnce(&str) -> Result<T, E>,
) -> anyhow::Result<T>
where
    E: std::error::Error + Send + Sync + 'static,
{
    let name = || path.display().to_string();
    let text = read_text(path, max_bytes).with_context(name)?;
    log::debug!("{}: {} bytes", path.display(), text.len());
    parse(&text).with_context(name)
}
