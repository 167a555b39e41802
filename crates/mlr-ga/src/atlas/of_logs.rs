use std::path::PathBuf;

use mlr_imu::Recording;
use mlr_model::{Gait, Robot};
use thiserror::Error;

use super::{Atlas, AtlasError};
use crate::{IdentifySettings, RecordedWalk};

/// Atlases of one robot, and which of them each of its logs has.
#[derive(Debug)]
pub struct AtlasesOfLogs {
    atlases: Vec<Atlas>,
    of_logs: Vec<Option<usize>>,
}

/// Why atlases cannot be used for logs.
#[derive(Debug, Error)]
pub enum AtlasesError {
    /// One of them cannot be used.
    #[error(transparent)]
    Atlas(#[from] AtlasError),
    /// One is of a gait that no log has, of several gaits.
    #[error(
        "{}: was made for a gait of none of the logs, expected one for {gaits}; leave it out, or \
         build another with `mlr-ga atlas build --gait …`",
        path.display()
    )]
    OfNoLog {
        /// The atlas.
        path: PathBuf,
        /// The gaits of the logs.
        gaits: String,
    },
}

impl AtlasesOfLogs {
    /// Opens atlases; each must belong to this robot and settings, and to one of the gaits of the logs.
    ///
    /// # Errors
    /// [`AtlasesError`] naming the file.
    pub fn open(
        paths: &[PathBuf],
        robot: &Robot,
        gaits: &[Gait],
        settings: &IdentifySettings,
    ) -> Result<Self, AtlasesError> {
        let mut opened = Self {
            atlases: Vec::new(),
            of_logs: vec![None; gaits.len()],
        };
        for path in paths {
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

    /// Recordings with their gaits and atlases.
    pub fn walks<'w>(
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
    pub fn of(&self, log: usize) -> Option<&Atlas> {
        let index = self.of_logs.get(log).copied().flatten()?;
        self.atlases.get(index)
    }
}

/// An atlas whose gait no log has: with several gaits, the error names them.
fn of_no_log(error: AtlasError, gaits: &[Gait]) -> AtlasesError {
    let mut names: Vec<&str> = gaits.iter().map(|gait| gait.name.as_str()).collect();
    names.dedup();
    if names.len() < 2 {
        return error.into();
    }
    AtlasesError::OfNoLog {
        path: error.path,
        gaits: names.join(" or "),
    }
}
