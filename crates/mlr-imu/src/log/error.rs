use std::{fmt, io, path::PathBuf, sync::Arc};

use thiserror::Error;

use super::excerpt::shortened;

/// A log that cannot be read or written: which file, and what is wrong with it.
#[derive(Debug, Error)]
#[error("{}: {problem}", path.display())]
pub struct LogError {
    /// The log.
    pub path: PathBuf,
    /// What is wrong.
    pub problem: LogProblem,
}

/// Where in a log something is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// A line of a text, from 1.
    Line(u64),
    /// A topic of a bag or an MCAP file.
    Topic(Arc<str>),
    /// One of its messages, from 1.
    Message(Arc<str>, u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Topic(topic) => write!(f, "topic {}", shortened(topic)),
            Self::Message(topic, number) => write!(f, "message {number} of {}", shortened(topic)),
        }
    }
}

/// A place among the bytes of a bag or an MCAP file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Position {
    /// From the beginning of the file, or of what a chunk contains.
    pub byte: u64,
    /// Where in the file that chunk begins.
    pub chunk: Option<u64>,
}

impl fmt::Display for Position {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "byte {}", self.byte)?;
        match self.chunk {
            Some(chunk) => write!(f, " of the chunk at byte {chunk}"),
            None => Ok(()),
        }
    }
}

/// What is wrong with a log.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LogProblem {
    /// It cannot be opened, read or written.
    #[error("{0}")]
    Io(io::Error),
    /// A directory has the name of the log.
    #[error(
        "is a directory, expected a file: .csv, .csv.gz, .bag or .mcap (of a ROS 2 bag the .mcap inside it)"
    )]
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
    #[error("{place}: no column {column:?}, found {found}{hint}")]
    MissingColumn {
        /// The header.
        place: Place,
        /// The name looked for.
        column: String,
        /// The names that are there.
        found: Box<str>,
        /// What to type instead.
        hint: Box<str>,
    },
    /// A column's name is there twice.
    #[error("{place}: column {column:?} appears more than once (capitals make no difference)")]
    AmbiguousColumn {
        /// The header.
        place: Place,
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
    #[error("{place}, column {column:?}: {text:?} is not a finite number")]
    NotANumber {
        /// The row.
        place: Place,
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
        "{place}: the quaternion of columns {columns} has the norm {norm:.3}, expected 1 \
         within 2 %"
    )]
    NotUnitQuaternion {
        /// The row.
        place: Place,
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
        "{place}: has more than {max_rows} rows, the most that are read; keep only the stretch \
         around the walk, or allow more with --max-rows"
    )]
    TooManyRows {
        /// The first row too many.
        place: Place,
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
    /// A bag or an MCAP file that is cut, damaged or larger than what is read.
    #[error("{position}: {what}")]
    Container {
        /// Where.
        position: Position,
        /// What is wrong there.
        what: String,
    },
    /// A file of a format that is known and not read.
    #[error("{0}")]
    OtherFormat(&'static str),
    /// A name that does not say in which format a log is to be written.
    #[error("expected a name that ends in .csv, .csv.gz or .mcap; bags are only read")]
    UnknownFormat,
    /// No messages of the right type.
    #[error("has no messages of sensor_msgs/Imu, found {found}")]
    NoImuTopic {
        /// The topics that are there, with their types.
        found: String,
    },
    /// Several topics that may be meant.
    #[error("has several topics of sensor_msgs/Imu: {found}; choose one with --topic NAME")]
    SeveralTopics {
        /// The topics, with their numbers of messages.
        found: String,
    },
    /// The topic asked for cannot be read.
    #[error("topic {topic:?} {what}; topics of sensor_msgs/Imu: {found}")]
    Topic {
        /// The topic asked for.
        topic: String,
        /// Why not.
        what: String,
        /// Those that could be.
        found: String,
    },
}
