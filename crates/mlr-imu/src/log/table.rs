//! The numbers of a log, column by column.

use std::{
    fs::File,
    io::{BufRead as _, BufReader, Read},
    path::Path,
};

use flate2::bufread::MultiGzDecoder;

use super::{
    LogLimits, LogProblem,
    excerpt::{listed, shortened},
    fields::{Delimiter, Fields, Splitter},
    lines::Lines,
    number::{Numbers, decimals},
    skipped_rows::SkippedRows,
    stream::IN_BODY_AXES,
    suggestion,
    time_stamp::TimeStamps,
};

/// The first bytes of every gzip file (RFC 1952).
const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];
/// The first line of tables that a spreadsheet is to open, as in `sep=;`.
const SPREADSHEET_HINT: &[u8] = b"sep=";
/// Rows from which on the last number of the last one can be compared with those before.
const MANY_ROWS: usize = 20;

/// A log whose header has been read and whose rows have not.
///
/// Every row is a line of its own. Lines that begin with `#` are skipped: loggers like to
/// note their settings.
pub struct LogTable<R> {
    lines: Lines<R>,
    splitter: Splitter,
    limits: LogLimits,
    names: Vec<String>,
    /// That of the header, from 1.
    line: u64,
    numbers: Numbers,
    in_body_axes: bool,
}

/// A column whose numbers are wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogColumn {
    /// Which of the columns it is.
    index: usize,
    /// What its numbers are multiplied by.
    factor: f64,
    holds: Holds,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Holds {
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
    /// Opens a file, plain or gzipped (told by its first bytes, not by its name).
    ///
    /// # Errors
    /// [`LogProblem`] when there is no header to be read.
    pub fn open(path: &Path, limits: LogLimits) -> Result<Self, LogProblem> {
        let file = File::open(path).map_err(LogProblem::Io)?;
        if file.metadata().map_err(LogProblem::Io)?.is_dir() {
            return Err(LogProblem::Directory);
        }
        Self::from_bytes(file, limits)
    }
}

impl<'a> LogTable<Box<dyn Read + 'a>> {
    /// Begins to read bytes, plain or gzipped.
    ///
    /// # Errors
    /// [`LogProblem`] when there is no header to be read.
    pub fn from_bytes(bytes: impl Read + 'a, limits: LogLimits) -> Result<Self, LogProblem> {
        let mut reader = BufReader::new(bytes);
        let start = reader.fill_buf().map_err(LogProblem::Io)?;
        let text: Box<dyn Read + 'a> = if start.starts_with(&GZIP_MAGIC) {
            Box::new(MultiGzDecoder::new(reader))
        } else {
            Box::new(reader)
        };
        Self::new(text, limits)
    }
}

impl<R: Read> LogTable<R> {
    /// Reads the header of a text.
    ///
    /// # Errors
    /// [`LogProblem`] when there is none.
    pub fn new(text: R, limits: LogLimits) -> Result<Self, LogProblem> {
        let mut lines = Lines::new(text, limits)?;
        let mut in_body_axes = false;
        let (line, delimiter, splitter, names) = loop {
            let Some(line) = lines.next()? else {
                return Err(LogProblem::Empty);
            };
            if is_no_row(line.text) || line.text.starts_with(SPREADSHEET_HINT) {
                in_body_axes |= line
                    .text
                    .trim_ascii_end()
                    .ends_with(IN_BODY_AXES.as_bytes());
                continue;
            }
            let delimiter = Delimiter::of_header(line.text);
            let mut splitter = Splitter::new(delimiter, limits.max_columns);
            let fields = splitter.split(line.text);
            let fields = fields.ok_or(LogProblem::TooManyColumns {
                line: line.number,
                max_columns: limits.max_columns,
            })?;
            let names: Result<Vec<String>, _> = fields
                .iter()
                .map(|name| str::from_utf8(name).map(String::from))
                .collect();
            let names = names.map_err(|_| LogProblem::NotText { line: line.number })?;
            break (line.number, delimiter, splitter, names);
        };
        if names.iter().all(String::is_empty) {
            return Err(LogProblem::Empty);
        }
        Ok(Self {
            lines,
            splitter,
            limits,
            names,
            line,
            numbers: Numbers::new(delimiter.leaves_commas_to_numbers()),
            in_body_axes,
        })
    }

    /// Whether a comment above the header says that the rows are in the body's axes
    /// ([`IN_BODY_AXES`]).
    pub fn is_in_body_axes(&self) -> bool {
        self.in_body_axes
    }

    /// The names of the columns.
    pub fn names(&self) -> &[String] {
        &self.names
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
                line: self.line,
                column: shortened(column),
                found: listed(self.names.iter().map(String::as_str)),
                hint: match near.as_slice() {
                    [] => String::new(),
                    near => format!("; near it: {}", listed(near.iter().copied())),
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
                line: self.line,
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
    /// [`LogProblem`] naming line and column.
    pub fn read(self, wanted: &[LogColumn]) -> Result<LogValues, LogProblem> {
        self.read_checked(wanted, |_, _| Ok(()))
    }

    /// Like [`LogTable::read`]. A row whose line and numbers do not pass the check counts as one
    /// that cannot be read.
    pub(super) fn read_checked(
        mut self,
        wanted: &[LogColumn],
        check: impl Fn(u64, &[f64]) -> Result<(), LogProblem>,
    ) -> Result<LogValues, LogProblem> {
        let mut columns = vec![Vec::new(); wanted.len()];
        let mut row = RowReader::new(wanted, &self.names, self.numbers);
        let mut skipped = SkippedRows::new(self.limits);
        let mut notes = Vec::new();
        while let Some(line) = self.lines.next()? {
            if is_no_row(line.text) {
                continue;
            }
            skipped.begin_row(line.number)?;
            let begun = columns.first().map_or(0, Vec::len);
            let fields = self.splitter.split(line.text);
            let fields = fields.ok_or(LogProblem::TooManyColumns {
                line: line.number,
                max_columns: self.limits.max_columns,
            })?;
            let problem = row
                .read(line.number, fields)
                .and_then(|()| check(line.number, &row.values))
                .err();
            let is_cut = !line.is_ended
                && begun > 0
                && row.is_cut(fields, problem.as_ref(), begun >= MANY_ROWS);
            if is_cut {
                skipped.forget_row();
                notes.push(format!(
                    "line {}: the last row is cut off and left out",
                    line.number
                ));
                break;
            }
            match problem {
                None => {
                    skipped.keep();
                    row.last_decimals = decimals(fields.get(fields.len().saturating_sub(1)));
                    for (column, value) in columns.iter_mut().zip(&row.values) {
                        column.push(*value);
                    }
                }
                Some(problem) => skipped.skip(problem)?,
            }
        }
        notes.extend(skipped.finish()?);
        if columns.iter().any(Vec::is_empty) {
            return Err(LogProblem::NoSamples);
        }
        notes.extend(row.note_on_commas()?);
        Ok(LogValues { columns, notes })
    }
}

/// Whether a line is empty or a comment.
fn is_no_row(line: &[u8]) -> bool {
    line.starts_with(b"#") || line.trim_ascii().is_empty()
}

/// Reads the wanted numbers of one row after the other.
struct RowReader<'a> {
    wanted: &'a [LogColumn],
    names: &'a [String],
    numbers: Numbers,
    times: Vec<TimeStamps>,
    /// Of the row read last.
    values: Vec<f64>,
    /// Digits behind the point of the last number of the row before.
    last_decimals: usize,
    /// Which field could not be read.
    failed: usize,
    /// Where the first decimal comma was.
    first_comma: Option<(u64, usize, String)>,
}

impl<'a> RowReader<'a> {
    fn new(wanted: &'a [LogColumn], names: &'a [String], numbers: Numbers) -> Self {
        Self {
            wanted,
            names,
            numbers,
            times: wanted
                .iter()
                .map(|column| TimeStamps::new(column.factor))
                .collect(),
            values: vec![0.0; wanted.len()],
            last_decimals: 0,
            failed: 0,
            first_comma: None,
        }
    }

    fn read(&mut self, line: u64, fields: Fields<'_>) -> Result<(), LogProblem> {
        if fields.len() != self.names.len() {
            return Err(LogProblem::RowLength {
                line,
                fields: fields.len() as u64,
                expected: self.names.len() as u64,
            });
        }
        let columns = self.wanted.iter().zip(&mut self.times);
        for ((column, times), value) in columns.zip(&mut self.values) {
            let field = fields.get(column.index);
            let number = match column.holds {
                Holds::TimeStamps => times.parse_s(field, &mut self.numbers),
                Holds::Numbers => self.numbers.parse(field).map(|x| x * column.factor),
                Holds::NumbersOrNothing => {
                    let number = self.numbers.parse(field).map(|x| x * column.factor);
                    *value = number.filter(|x| x.is_finite()).unwrap_or(f64::NAN);
                    continue;
                }
            };
            let name = || self.names.get(column.index).cloned().unwrap_or_default();
            let Some(number) = number.filter(|number| number.is_finite()) else {
                self.failed = column.index;
                let Ok(text) = str::from_utf8(field) else {
                    return Err(LogProblem::NotText { line });
                };
                return Err(LogProblem::NotANumber {
                    line,
                    column: shortened(&name()),
                    text: shortened(text),
                });
            };
            *value = number;
            if self.first_comma.is_none() && self.numbers.decimal_commas().is_some() {
                let text = String::from_utf8_lossy(field);
                self.first_comma = Some((line, column.index, shortened(&text)));
            }
        }
        Ok(())
    }

    /// Whether a row at the end of the text, without a line end, is only the beginning of one:
    /// fields are missing, the last one cannot be read, or its number is shorter than the one
    /// before.
    fn is_cut(&self, fields: Fields<'_>, problem: Option<&LogProblem>, after_many: bool) -> bool {
        let last = fields.len().saturating_sub(1);
        match problem {
            Some(LogProblem::RowLength {
                fields, expected, ..
            }) => fields < expected,
            Some(LogProblem::NotANumber { .. }) => self.failed == last,
            Some(_) => false,
            None => after_many && decimals(fields.get(last)) < self.last_decimals,
        }
    }

    /// What to tell of decimal commas, if there were any.
    fn note_on_commas(self) -> Result<Option<String>, LogProblem> {
        let Some((line, index, text)) = self.first_comma else {
            return Ok(None);
        };
        let column = self.names.get(index).map(|name| shortened(name));
        let column = column.unwrap_or_default();
        if self.numbers.decimal_commas() == Some(false) {
            return Err(LogProblem::AmbiguousComma { line, column, text });
        }
        Ok(Some(format!(
            "line {line}, column {column:?}: the comma of {text:?} is read as a decimal comma, \
             like all others"
        )))
    }
}
