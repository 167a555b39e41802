use std::{io, path::PathBuf};

use thiserror::Error;

/// A log that cannot be read or written: which file, and what is wrong with it.
#[derive(Debug, Error)]
#[error("{}: {problem}", path.display())]
pub struct LogError {
    /// The log.
    pub path: PathBuf,
    /// What is wrong.
    pub problem: LogProblem,
}

/// What is wrong with a log.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LogProblem {
    /// It cannot be opened, read or written.
    #[error("{0}")]
    Io(io::Error),
    /// A directory has the name of the log.
    #[error("is a directory, expected a .csv or .csv.gz file")]
    Directory,
    /// A file of that name is already there.
    #[error("already exists and is not overwritten")]
    Exists,
    /// The compressed data end early or are damaged.
    #[error("line {line}: the gzip data are damaged or end early: {source}")]
    Gzip {
        /// Line of the text after which reading failed.
        line: u64,
        /// What the decoder said.
        source: io::Error,
    },
    /// There is not even a header.
    #[error("is empty, expected a header line with the names of the columns")]
    Empty,
    /// There is a header and nothing else.
    #[error("has a header but no samples")]
    NoSamples,
    /// A column is not there.
    #[error("line {line}: no column {column:?}, found {found}{hint}")]
    MissingColumn {
        /// Line of the header.
        line: u64,
        /// The name looked for.
        column: String,
        /// The names that are there.
        found: String,
        /// What to type instead.
        hint: String,
    },
    /// A column's name is there twice.
    #[error("line {line}: column {column:?} appears more than once (capitals make no difference)")]
    AmbiguousColumn {
        /// Line of the header.
        line: u64,
        /// The name.
        column: String,
    },
    /// A row has fewer or more fields than the header.
    #[error("line {line}: {fields} fields, expected {expected} as in the header")]
    RowLength {
        /// Line in the file, from 1.
        line: u64,
        /// Fields found.
        fields: u64,
        /// Fields of the header.
        expected: u64,
    },
    /// A field is not a finite number.
    #[error("line {line}, column {column:?}: {text:?} is not a finite number")]
    NotANumber {
        /// Line in the file, from 1.
        line: u64,
        /// Name of the column.
        column: String,
        /// What is there.
        text: String,
    },
    /// The numbers do not make a recording.
    #[error(transparent)]
    Series(#[from] mlr_filter::SeriesError),
    /// The file is not text.
    #[error("line {line}: is not UTF-8 text")]
    NotText {
        /// Line in the file, from 1.
        line: u64,
    },
    /// Commas that could separate decimals as well as thousands.
    #[error(
        "line {line}, column {column:?}: the comma of {text:?} may separate decimals or thousands, \
         and no other number tells which; expected decimal points"
    )]
    AmbiguousComma {
        /// Line of the first such number, from 1.
        line: u64,
        /// Name of its column.
        column: String,
        /// What is there.
        text: String,
    },
    /// Four numbers that are no orientation.
    #[error(
        "line {line}: the quaternion of columns {columns} has the norm {norm:.3}, expected 1 \
         within 2 %"
    )]
    NotUnitQuaternion {
        /// Line in the file, from 1.
        line: u64,
        /// The names of the columns.
        columns: String,
        /// What was found.
        norm: f64,
    },
    /// A line without an end.
    #[error(
        "line {line}: is longer than {max_bytes} bytes, the most that is read of a line; expected \
         one row of numbers on each line"
    )]
    LineTooLong {
        /// Line in the file, from 1.
        line: u64,
        /// The limit.
        max_bytes: usize,
    },
    /// More columns than any log has.
    #[error(
        "line {line}: has more than {max_columns} columns, the most that are read; leave out those \
         that are not needed"
    )]
    TooManyColumns {
        /// Line in the file, from 1.
        line: u64,
        /// The limit.
        max_columns: usize,
    },
    /// A log that is too long.
    #[error(
        "line {line}: has more than {max_rows} rows, the most that are read; keep only the stretch \
         around the walk, or allow more with --max-rows"
    )]
    TooManyRows {
        /// Line of the first row too many, from 1.
        line: u64,
        /// The limit.
        max_rows: u64,
    },
    /// A log that is too large.
    #[error(
        "line {line}: has more than {} MB of text, the most that is read; keep only the stretch \
         around the walk, or the columns that are needed", max_bytes / 1_000_000
    )]
    TooMuchText {
        /// Line in the file, from 1.
        line: u64,
        /// The limit.
        max_bytes: u64,
    },
}
