//! Walks of the model, simulated beforehand, for the logs of one robot.

use std::path::PathBuf;

use clap::Args;
use mlr_ga::{
    IdentifySettings,
    atlas::{AtlasesError, AtlasesOfLogs},
};
use mlr_model::{Gait, Robot};

/// The atlases of several logs.
#[derive(Debug, Args)]
pub(super) struct AtlasFiles {
    /// Walks simulated beforehand by `mlr-ga atlas build`. Of logs with several gaits, one for each
    /// gait: every log is compared with the walks of its own, and simulated where there is none.
    #[arg(long, value_name = "FILE")]
    atlas: Vec<PathBuf>,
}

impl AtlasFiles {
    /// Opens them; each must belong to this robot and settings, and to one of the gaits of the logs.
    pub(super) fn open(
        &self,
        robot: &Robot,
        gaits: &[Gait],
        settings: &IdentifySettings,
    ) -> Result<AtlasesOfLogs, AtlasesError> {
        AtlasesOfLogs::open(&self.atlas, robot, gaits, settings)
    }
}
