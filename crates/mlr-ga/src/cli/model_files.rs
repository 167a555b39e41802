//! Robot and gait, embedded or from the user's files, their atlas, and settings.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, ValueEnum};
use mlr_ga::{
    DescribedRobot, IdentifySettings, Method, ModelFileError, atlas::Atlas, robot_of_file,
};
use mlr_model::{Gait, Robot};

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

impl ModelFiles {
    /// Robot and gait, which fit together.
    pub(super) fn read(&self) -> Result<(Robot, Gait), ModelFileError> {
        let described = self.robot.read()?;
        let gait = described.gait(self.gait.as_deref())?;
        Ok((described.robot, gait))
    }

    /// The robot, where its gait does not matter.
    pub(super) fn robot(&self) -> Result<Robot, ModelFileError> {
        Ok(self.robot.read()?.robot)
    }
}

impl ModelOfLogs {
    /// The file that describes the robot, if one was named.
    pub(super) fn robot_file(&self) -> Option<&Path> {
        self.robot.robot.as_deref()
    }

    /// The robot, the text that describes it, and the gait of each of so many logs.
    pub(super) fn read(&self, logs: usize) -> Result<(Robot, String, Vec<Gait>), ModelFileError> {
        let described = self.robot.read()?;
        let gaits = described.gaits(&self.gait, logs)?;
        Ok((described.robot, described.text, gaits))
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
    pub(super) fn of(&self, log: &str) -> Result<Option<Robot>, ModelFileError> {
        let path = self.own_robots.as_ref();
        let path = path.map(|directory| directory.join(format!("{log}.toml")));
        path.as_deref().map(robot_of_file).transpose()
    }
}

impl RobotFile {
    fn read(&self) -> Result<DescribedRobot, ModelFileError> {
        DescribedRobot::read(self.robot.as_deref())
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
