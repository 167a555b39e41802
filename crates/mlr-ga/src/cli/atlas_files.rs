//! Walks of the model, simulated beforehand, for the logs of one robot.

use std::path::PathBuf;

use clap::Args;
use mlr_ga::{
    IdentifySettings, RecordedWalk,
    atlas::{Atlas, AtlasError},
};
use mlr_imu::Recording;
use mlr_model::{Gait, Robot};

/// The atlases of several logs.
#[derive(Debug, Args)]
pub(super) struct AtlasFiles {
    /// Walks simulated beforehand by `mlr-ga atlas build`. Of logs with several gaits, one for each
    /// gait: every log is compared with the walks of its own, and simulated where there is none.
    #[arg(long, value_name = "FILE")]
    atlas: Vec<PathBuf>,
}

/// Atlases, and which of them each log has.
#[derive(Debug)]
pub(super) struct Atlases {
    atlases: Vec<Atlas>,
    of_logs: Vec<Option<usize>>,
}

impl AtlasFiles {
    /// Opens them; each must belong to this robot and settings, and to one of the gaits of the logs.
    pub(super) fn open(
        &self,
        robot: &Robot,
        gaits: &[Gait],
        settings: &IdentifySettings,
    ) -> anyhow::Result<Atlases> {
        let mut opened = Atlases {
            atlases: Vec::new(),
            of_logs: vec![None; gaits.len()],
        };
        for path in &self.atlas {
            let mut refused: Option<AtlasError> = None;
            let open = |gait: &Gait| match Atlas::open(path, robot, gait, settings) {
                Ok(atlas) => Some(Ok((atlas, gait.clone()))),
                Err(error) if error.is_of_another_gait() => {
                    refused.get_or_insert(error);
                    None
                }
                Err(error) => Some(Err(error)),
            };
            // What another log of the same gait would say is known already.
            let different = gaits.iter().enumerate();
            let different = different.filter(|(log, gait)| !gaits[..*log].contains(gait));
            let found = different.map(|(_, gait)| gait).find_map(open);
            let Some(found) = found else {
                let Some(refused) = refused else { continue };
                return Err(of_no_log(refused, gaits));
            };
            let (atlas, gait) = found?;
            for (of_log, own) in opened.of_logs.iter_mut().zip(gaits) {
                if *own == gait {
                    *of_log = Some(opened.atlases.len());
                }
            }
            opened.atlases.push(atlas);
        }
        Ok(opened)
    }
}

impl Atlases {
    /// Recordings with their gaits and atlases.
    pub(super) fn walks<'w>(
        &'w self,
        recordings: &'w [Recording],
        gaits: &'w [Gait],
    ) -> Vec<RecordedWalk<'w>> {
        let each = recordings.iter().zip(gaits).enumerate();
        let walks = each.map(|(log, (recording, gait))| RecordedWalk {
            recording,
            gait,
            atlas: self.of(log),
        });
        walks.collect()
    }

    /// The atlas of a log.
    pub(super) fn of(&self, log: usize) -> Option<&Atlas> {
        let index = self.of_logs.get(log).copied().flatten()?;
        self.atlases.get(index)
    }
}

/// An atlas whose gait no log has: with several gaits, the error names them.
fn of_no_log(error: AtlasError, gaits: &[Gait]) -> anyhow::Error {
    let mut names: Vec<&str> = gaits.iter().map(|gait| gait.name.as_str()).collect();
    names.dedup();
    if names.len() < 2 {
        return error.into();
    }
    anyhow::anyhow!(
        "{}: was made for a gait of none of the logs, expected one for {}; leave it out, or build \
         another with `mlr-ga atlas build --gait …`",
        error.path.display(),
        names.join(" or ")
    )
}
