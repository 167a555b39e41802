//! The log that a command reads.

use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use mlr_ga::AnswerError;
use mlr_imu::{Columns, Recording, read_log};

#[derive(Debug, Args)]
pub(super) struct LogFile {
    /// The log: .csv or .csv.gz with the columns t_s and either roll_rad, pitch_rad, yaw_rad or raw
    /// samples ax_mps2, ay_mps2, az_mps2, gx_radps, gy_radps, gz_radps, which are then fused.
    log: PathBuf,
    /// A foreign column: QUANTITY=NAME[,UNIT] with the quantities t, roll, pitch, yaw, ax, ay, az, gx,
    /// gy, gz and the units s, ms, us, ns; rad, deg; mps2, g; radps, dps.
    #[arg(long, value_name = "MAPPING")]
    column: Vec<String>,
}

impl LogFile {
    pub(super) fn path(&self) -> &PathBuf {
        &self.log
    }

    pub(super) fn read(&self) -> anyhow::Result<Recording> {
        Ok(read_log(&self.log, &self.columns()?)?)
    }

    fn columns(&self) -> anyhow::Result<Columns> {
        let mut columns = Columns::default();
        for mapping in &self.column {
            columns.rename(mapping).context("--column")?;
        }
        Ok(columns)
    }

    /// Names the log in an error that is the log's fault.
    pub(super) fn blame(&self, error: AnswerError) -> anyhow::Error {
        let of_the_log = error.is_recordings_fault();
        self.blame_if(of_the_log, error.into())
    }

    /// Names the log in an error if that is the log's fault.
    pub(super) fn blame_if(&self, of_the_log: bool, error: anyhow::Error) -> anyhow::Error {
        if of_the_log {
            error.context(self.log.display().to_string())
        } else {
            error
        }
    }
}
