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
    #[error("line {line}: no column {column:?}, found {found}")]
    MissingColumn {
        /// Line of the header.
        line: u64,
        /// The name looked for.
        column: String,
        /// The names that are there.
        found: String,
    },
    /// A column's name is there twice.
    #[error("line {line}: column {column:?} appears more than once")]
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
}
