//! Log files: CSV and its relatives, plain or gzipped.

mod angles;
mod columns;
mod error;
mod excerpt;
mod fields;
mod limits;
mod lines;
mod number;
mod read;
mod skipped_rows;
mod stream;
mod suggestion;
mod table;
mod time_stamp;
mod write;

pub use columns::{ColumnError, Columns, Correction};
pub use error::{LogError, LogProblem};
pub use limits::LogLimits;
pub use read::read_log;
pub use stream::{IN_BODY_AXES, LogStream};
pub use table::{LogColumn, LogTable, LogValues};
pub use write::{write_log, write_log_to};
