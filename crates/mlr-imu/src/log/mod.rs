//! Log files: CSV and its relatives, ROS 1 bags and MCAP, plain or gzipped.

mod angles;
mod columns;
mod error;
mod excerpt;
mod fields;
mod format;
mod limits;
mod lines;
mod number;
mod read;
mod ros;
mod sample_lines;
mod skipped_rows;
mod stream;
mod suggestion;
mod table;
mod text_rows;
mod time_stamp;
mod write;

pub(crate) use angles::unwrapped;
pub use columns::{ColumnError, Columns, Correction};
pub use error::{LogError, LogProblem, Place, Position};
pub use limits::LogLimits;
pub use read::read_log;
pub use ros::{ImuRows, McapBegin, McapStream, mcap_library};
pub use sample_lines::SampleLines;
pub use stream::{IN_BODY_AXES, LogStream};
pub use table::{LogColumn, LogTable, LogValues};
pub use write::{LogFormat, write_log, write_log_to, write_recording};
