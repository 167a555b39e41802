//! The files of a motion that was found.

use std::path::PathBuf;

use clap::Args;
use mlr_model::{Gait, Motion, Robot};

use super::output::{ResultFile, Table};

/// Where a gait or another motion is written to.
#[derive(Debug, Args)]
pub(super) struct MotionFiles {
    /// Write the motion to this file, a gait in TOML that every command takes as --gait. An existing
    /// file is never overwritten.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Also write it as the joint angles that a controller plays, as CSV. An existing file is never
    /// overwritten.
    #[arg(long, value_name = "FILE")]
    joints: Option<PathBuf>,
}

/// The files, which did not exist.
pub(super) struct ReservedFiles {
    motion: ResultFile,
    joints: Option<ResultFile>,
}

impl MotionFiles {
    /// Makes sure that they can be written before the work begins.
    pub(super) fn reserve(&self) -> anyhow::Result<ReservedFiles> {
        let joints = self.joints.as_deref().map(ResultFile::reserve);
        Ok(ReservedFiles {
            motion: ResultFile::reserve(&self.output)?,
            joints: joints.transpose()?,
        })
    }

    /// Names them in a table, with what there is to say about the motion.
    pub(super) fn name(&self, motion: &str, about: &str, table: &mut Table) {
        table.line(motion, format!("{}{about}", self.output.display()));
        if let Some(joints) = &self.joints {
            table.line("joints", joints.display());
        }
    }
}

impl ReservedFiles {
    /// Writes the motion of this robot.
    pub(super) fn write(self, motion: &Gait, robot: &Robot) -> anyhow::Result<()> {
        self.motion.write(motion.to_toml())?;
        if let (Some(file), Motion::Joints(joints)) = (self.joints, &motion.motion) {
            file.write(&joints.to_csv(robot)?)?;
        }
        Ok(())
    }
}
