//! Robot and gait, embedded or from the user's files, and their atlas.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;
use mlr_ga::{IdentifySettings, atlas::Atlas};
use mlr_imu::{MAX_TEXT_BYTES, read_text};
use mlr_model::{Gait, Robot};
use serde::de::DeserializeOwned;

/// Replaces the embedded robot and gait.
#[derive(Debug, Args)]
pub(super) struct ModelFiles {
    /// Robot description in TOML [default: the embedded JetHexa].
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// Gait in TOML [default: the embedded tripod].
    #[arg(long, value_name = "FILE")]
    gait: Option<PathBuf>,
}

impl ModelFiles {
    pub(super) fn robot(&self) -> anyhow::Result<Robot> {
        load(self.robot.as_deref(), Robot::from_toml)
            .map(|robot| robot.unwrap_or_else(Robot::jethexa))
    }

    pub(super) fn gait(&self) -> anyhow::Result<Gait> {
        load(self.gait.as_deref(), Gait::from_toml).map(|gait| gait.unwrap_or_else(Gait::tripod))
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

/// Settings from a file in TOML; the default ones where none is named.
pub(super) fn settings<S: DeserializeOwned + Default>(path: Option<&Path>) -> anyhow::Result<S> {
    load(path, |text| toml::from_str(text)).map(Option::unwrap_or_default)
}

/// Reads and parses a file, if there is one to read; errors name it.
fn load<T, E>(
    path: Option<&Path>,
    parse: impl FnOnce(&str) -> Result<T, E>,
) -> anyhow::Result<Option<T>>
where
    E: std::error::Error + Send + Sync + 'static,
{
    let Some(path) = path else { return Ok(None) };
    let name = || path.display().to_string();
    let text = read_text(path, MAX_TEXT_BYTES).with_context(name)?;
    parse(&text).map(Some).with_context(name)
}
