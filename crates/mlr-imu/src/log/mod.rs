//! Log files: CSV, plain or gzipped.

mod columns;
mod error;
mod read;
mod stream;
mod table;
mod write;

pub use columns::{ColumnError, Columns, Correction};
pub use error::{LogError, LogProblem};
pub use read::read_log;
pub use stream::LogStream;
pub use table::LogTable;
pub use write::write_log;
