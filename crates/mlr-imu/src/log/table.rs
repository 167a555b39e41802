//! The numbers of a log, column by column.

use std::{fs::File, io::Read, path::Path};

use flate2::bufread::MultiGzDecoder;

use super::{
    LogLimits, LogProblem, Place,
    excerpt::{listed, shortened},
    format::Format,
    lines::unreadable,
    ros::{self, ImuRows},
    suggestion,
    text_rows::TextRows,
};

/// A log whose columns are known and whose rows have not been looked at.
///
/// In a text every row is a line of its own. Lines that begin with `#` are skipped: loggers like
/// to note their settings. The messages of a bag or an MCAP file are rows with the columns `t_s`
/// and, as far as they hold them, `qw` to `qz` and the raw samples `ax_mps2` to `gz_radps`.
pub struct LogTable<R> {
    rows: Rows<R>,
    names: Vec<String>,
    header: Place,
    in_body_axes: bool,
    notes: Vec<String>,
}

enum Rows<R> {
    Text(Box<TextRows<R>>),
    Messages(ImuRows),
}

/// A column whose numbers are wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogColumn {
    /// Which of the columns it is.
    pub(super) index: usize,
    /// What its numbers are multiplied by.
    pub(super) factor: f64,
    pub(super) holds: Holds,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Holds {
    TimeStamps,
    Numbers,
    /// A row without one is read nevertheless.
    NumbersOrNothing,
}

impl LogColumn {
    /// Time stamps: numbers of a unit of this many seconds, or dates with times of day (ISO 8601,
    /// RFC 3339), which give the seconds since the first.
    pub fn of_times(index: usize, unit_s: f64) -> Self {
        Self {
            index,
            factor: unit_s,
            holds: Holds::TimeStamps,
        }
    }

    /// Numbers, each times a factor.
    pub fn of_numbers(index: usize, factor: f64) -> Self {
        Self {
            index,
            factor,
            holds: Holds::Numbers,
        }
    }

    /// Numbers that may be missing: what is no number is read as NaN.
    pub(super) fn of_optional_numbers(index: usize, factor: f64) -> Self {
        Self {
            index,
            factor,
            holds: Holds::NumbersOrNothing,
        }
    }
}

/// What was read of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct LogValues {
    /// The numbers of each wanted column, in the order in which they were asked for.
    pub columns: Vec<Vec<f64>>,
    /// What a person should know about how they were read.
    pub notes: Vec<String>,
}

impl LogTable<Box<dyn Read>> {
    /// Opens a file of any format: see [`LogTable::from_bytes`].
    ///
    /// # Errors
    /// [`LogProblem`] when there is no table to be read.
    pub fn open(path: &Path, topic: Option<&str>, limits: LogLimits) -> Result<Self, LogProblem> {
        let file = File::open(path).map_err(LogProblem::Io)?;
        if file.metadata().map_err(LogProblem::Io)?.is_dir() {
            return Err(LogProblem::Directory);
        }
        Self::from_bytes(file, topic, limits)
    }
}

impl<'a> LogTable<Box<dyn Read + 'a>> {
    /// Begins to read bytes of any format, told by the first of them: text, a ROS 1 bag, or MCAP,
    /// plain or gzipped. Of a bag and of MCAP, the messages of sensor_msgs/Imu on one `topic` are
    /// read; it need not be named where it is the only one.
    ///
    /// # Errors
    /// [`LogProblem`] when there is no table to be read.
    pub fn from_bytes(
        bytes: impl Read + 'a,
        topic: Option<&str>,
        limits: LogLimits,
    ) -> Result<Self, LogProblem> {
        let (format, bytes) = Format::told_by(bytes).map_err(LogProblem::Io)?;
        let (format, bytes): (_, Box<dyn Read + 'a>) = match format {
            Format::Gzip => {
                let content = Format::told_by(MultiGzDecoder::new(bytes));
                let (format, bytes) = content.map_err(|error| unreadable(error, 1))?;
                (format, Box::new(bytes))
            }
            format => (format, Box::new(bytes)),
        };
        let messages = match format {
            Format::Bag => ros::read_bag(bytes, topic, limits)?,
            Format::Mcap => ros::read_mcap(bytes, topic, limits)?,
            Format::OtherBag => {
                let what = "is a bag of another version, expected 2.0; `rosbag fix` may convert it";
                return Err(LogProblem::OtherFormat(what));
            }
            Format::Sqlite => {
                let what = "is a database of SQLite, expected .mcap; `ros2 bag convert` makes that \
                    of a ROS 2 bag";
                return Err(LogProblem::OtherFormat(what));
            }
            Format::Text | Format::Gzip => {
                let mut table = Self::new(bytes, limits)?;
                if topic.is_some() {
                    let note = "--topic: a table has no topics; read without it";
                    table.notes.push(note.into());
                }
                return Ok(table);
            }
        };
        Ok(Self {
            names: messages.names(),
            header: Place::Topic(messages.topic().clone()),
            in_body_axes: messages.is_in_body_axes(),
            notes: Vec::new(),
            rows: Rows::Messages(messages),
        })
    }
}

impl<R: Read> LogTable<R> {
    /// Reads the header of a text.
    ///
    /// # Errors
    /// [`LogProblem`] when there is none.
    pub fn new(text: R, limits: LogLimits) -> Result<Self, LogProblem> {
        let (rows, header) = TextRows::new(text, limits)?;
        Ok(Self {
            rows: Rows::Text(Box::new(rows)),
            names: header.names,
            header: Place::Line(header.line),
            in_body_axes: header.in_body_axes,
            notes: Vec::new(),
        })
    }

    /// Whether a comment above the header, or what is noted of the topic, says that the rows are
    /// in the body's axes ([`super::IN_BODY_AXES`]).
    pub fn is_in_body_axes(&self) -> bool {
        self.in_body_axes
    }

    /// The names of the columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The messages, where the rows are messages.
    pub fn messages(&self) -> Option<&ImuRows> {
        match &self.rows {
            Rows::Text(_) => None,
            Rows::Messages(messages) => Some(messages),
        }
    }

    /// The index of the column of that name: written exactly so, or else with other capitals.
    ///
    /// # Errors
    /// [`LogProblem::MissingColumn`] or [`LogProblem::AmbiguousColumn`].
    pub fn find(&self, column: &str) -> Result<usize, LogProblem> {
        let folded = column.to_lowercase();
        let found = self
            .only(column, |name| name == column)
            .or_else(|| self.only(column, |name| name.to_lowercase() == folded));
        found.unwrap_or_else(|| {
            let near = suggestion::alike(column, &self.names);
            Err(LogProblem::MissingColumn {
                place: self.header.clone(),
                column: shortened(column),
                found: listed(self.names.iter().map(String::as_str)).into(),
                hint: match near.as_slice() {
                    [] => "".into(),
                    near => format!("; near it: {}", listed(near.iter().copied())).into(),
                },
            })
        })
    }

    /// The index of the only column whose name matches, if one does.
    fn only(
        &self,
        column: &str,
        matches: impl Fn(&str) -> bool,
    ) -> Option<Result<usize, LogProblem>> {
        let names = self.names.iter().enumerate();
        let mut found = names.filter(|(_, name)| matches(name));
        let (index, _) = found.next()?;
        Some(match found.next() {
            None => Ok(index),
            Some(_) => Err(LogProblem::AmbiguousColumn {
                place: self.header.clone(),
                column: shortened(column),
            }),
        })
    }

    /// Reads all rows.
    ///
    /// A last row that was cut off is left out, and so are single rows that cannot be read, as
    /// far as [`LogLimits`] allows; the notes tell.
    ///
    /// # Errors
    /// [`LogProblem`] naming line, or message, and column.
    pub fn read(self, wanted: &[LogColumn]) -> Result<LogValues, LogProblem> {
        self.read_checked(wanted, |_, _| Ok(()))
    }

    /// Like [`LogTable::read`]. A row whose place and numbers do not pass the check counts as one
    /// that cannot be read.
    pub(super) fn read_checked(
        self,
        wanted: &[LogColumn],
        check: impl Fn(&Place, &[f64]) -> Result<(), LogProblem>,
    ) -> Result<LogValues, LogProblem> {
        let mut values = match self.rows {
            Rows::Text(rows) => rows.read(&self.names, wanted, check)?,
            Rows::Messages(messages) => messages.read(wanted, check)?,
        };
        values.notes.splice(0..0, self.notes);
        Ok(values)
    }
}
