//! The log that a command reads.

use std::{
    fs::File,
    io::{self, Read},
    path::{Path, PathBuf},
};

use anyhow::Context;
use clap::Args;
use mlr_ga::AnswerError;
use mlr_imu::{Columns, LogError, LogLimits, LogProblem, LogTable, Mounting, Recording};
use sha2::{Digest, Sha256};

/// What stands for standard input as the name of a log.
const STDIN: &str = "-";

/// The log that a command answers.
#[derive(Debug, Args)]
pub(super) struct LogFile {
    /// The log: .csv or .csv.gz with the columns t_s and either roll_rad, pitch_rad, yaw_rad, or a
    /// quaternion qw, qx, qy, qz, or raw samples ax_mps2, ay_mps2, az_mps2, gx_radps, gy_radps,
    /// gz_radps, which are then fused; or a ROS 1 .bag or an .mcap with sensor_msgs/Imu. Fields of
    /// a table may be separated by commas, semicolons, tabs or spaces; times may be numbers or
    /// dates. - reads standard input.
    log: PathBuf,
    #[command(flatten)]
    read: ReadOptions,
}

/// The logs of one robot, whose columns have the same names.
#[derive(Debug, Args)]
pub(super) struct LogFiles {
    /// The logs of one robot: .csv or .csv.gz with the columns t_s and either roll_rad, pitch_rad,
    /// yaw_rad, or a quaternion qw, qx, qy, qz, or raw samples ax_mps2, ay_mps2, az_mps2, gx_radps,
    /// gy_radps, gz_radps, which are then fused; or ROS 1 .bag and .mcap with sensor_msgs/Imu.
    /// Fields of a table may be separated by commas, semicolons, tabs or spaces; times may be
    /// numbers or dates. - reads standard input.
    #[arg(value_name = "LOG", required = true)]
    logs: Vec<PathBuf>,
    #[command(flatten)]
    read: ReadOptions,
}

/// How logs are read.
#[derive(Debug, Clone, Args)]
pub(super) struct ReadOptions {
    /// A foreign column: QUANTITY=NAME[,UNIT] with the quantities t, roll, pitch, yaw, qw, qx, qy,
    /// qz, ax, ay, az, gx, gy, gz and the units s, ms, us, ns; rad, deg; mps2, g; radps, dps.
    /// QUANTITY=-NAME turns the sign, as in ay=-ay_mps2.
    #[arg(long, value_name = "MAPPING")]
    column: Vec<String>,
    #[command(flatten)]
    table: TableOptions,
}

/// Which table of a file is read, and how much of it.
#[derive(Debug, Clone, Args)]
pub(super) struct TableOptions {
    /// The topic of a bag or an MCAP file; needed where several hold sensor_msgs/Imu.
    #[arg(long, value_name = "NAME")]
    topic: Option<String>,
    /// The most rows that are read of a log; a longer one is refused.
    #[arg(long, value_name = "N", default_value_t = LogLimits::default().max_rows)]
    max_rows: u64,
}

impl TableOptions {
    /// Opens a log, or standard input for `-`, and reads it.
    pub(super) fn read<T>(
        &self,
        path: &Path,
        read: impl FnOnce(LogTable<Box<dyn Read>>) -> Result<T, LogProblem>,
    ) -> Result<T, LogError> {
        let limits = LogLimits {
            max_rows: self.max_rows,
            ..LogLimits::default()
        };
        let topic = self.topic.as_deref();
        let table = if path.as_os_str() == STDIN {
            LogTable::from_bytes(io::stdin(), topic, limits)
        } else {
            LogTable::open(path, topic, limits)
        };
        table.and_then(read).map_err(|problem| LogError {
            path: path.into(),
            problem,
        })
    }
}

impl LogFile {
    pub(super) fn path(&self) -> &PathBuf {
        &self.log
    }

    pub(super) fn read(&self) -> anyhow::Result<Recording> {
        self.read.recording(&self.log)
    }

    /// Has the log's table read with the columns that were mapped.
    pub(super) fn read_table<T>(
        &self,
        read: impl FnOnce(LogTable<Box<dyn Read>>, &Columns) -> Result<T, LogProblem>,
    ) -> anyhow::Result<T> {
        let columns = self.read.columns()?;
        let read = |table| read(table, &columns);
        Ok(self.read.table.read(&self.log, read)?)
    }

    /// Names the log in an error that is the log's fault.
    pub(super) fn blame(&self, error: AnswerError) -> anyhow::Error {
        let of_the_log = error.is_recordings_fault();
        self.blame_if(of_the_log, error.into())
    }

    /// Names the log in an error if that is the log's fault.
    pub(super) fn blame_if(&self, of_the_log: bool, error: anyhow::Error) -> anyhow::Error {
        blame_if(of_the_log, &self.log, error)
    }
}

impl LogFiles {
    /// Logs that a command may do without.
    pub(super) fn new(logs: Vec<PathBuf>, read: ReadOptions) -> Self {
        Self { logs, read }
    }

    pub(super) fn paths(&self) -> &[PathBuf] {
        &self.logs
    }

    /// What the sensor recorded in each log, in the axes of a robot that it is mounted on like this.
    pub(super) fn read(&self, mounting: &Mounting) -> anyhow::Result<Vec<Recording>> {
        let each = self.logs.iter();
        each.map(|log| Ok(self.read.recording(log)?.mounted(mounting)?))
            .collect()
    }

    /// The names of the logs.
    pub(super) fn names(&self) -> Vec<String> {
        let each = self.logs.iter();
        each.map(|log| log.display().to_string()).collect()
    }

    /// Names one of the logs in an error that is its fault.
    pub(super) fn blame(&self, index: usize, error: AnswerError) -> anyhow::Error {
        let of_the_log = error.is_recordings_fault();
        self.blame_if(index, of_the_log, error.into())
    }

    /// Names one of the logs in an error if that is its fault.
    pub(super) fn blame_if(
        &self,
        index: usize,
        of_the_log: bool,
        error: anyhow::Error,
    ) -> anyhow::Error {
        match self.logs.get(index) {
            Some(log) => blame_if(of_the_log, log, error),
            None => error,
        }
    }
}

/// Names a log in an error if that is the log's fault.
pub(super) fn blame_if(of_the_log: bool, log: &Path, error: anyhow::Error) -> anyhow::Error {
    if of_the_log {
        error.context(log.display().to_string())
    } else {
        error
    }
}

impl ReadOptions {
    /// What the sensor recorded.
    pub(super) fn recording(&self, log: &Path) -> anyhow::Result<Recording> {
        let columns = self.columns()?;
        let read = |table| Recording::from_table(table, &columns);
        Ok(self.table.read(log, read)?)
    }

    fn columns(&self) -> anyhow::Result<Columns> {
        let mut columns = Columns::default();
        for mapping in &self.column {
            columns.rename(mapping).context("--column")?;
        }
        Ok(columns)
    }
}

/// SHA-256 of a log's bytes; of standard input, nothing is left to read.
pub(super) fn sha256(log: &Path) -> anyhow::Result<Option<String>> {
    if log.as_os_str() == STDIN {
        return Ok(None);
    }
    let mut hash = Sha256::new();
    let name = || log.display().to_string();
    let mut file = File::open(log).with_context(name)?;
    io::copy(&mut file, &mut hash).with_context(name)?;
    let bytes = hash.finalize();
    let digits = bytes.iter().map(|byte| format!("{byte:02x}"));
    Ok(Some(digits.collect()))
}
