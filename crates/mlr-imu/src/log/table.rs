//! The numbers of a log, column by column.

use std::{
    fs::File,
    io::{self, BufRead as _, BufReader, Read},
    path::Path,
};

use csv::{ErrorKind, StringRecord};
use flate2::bufread::MultiGzDecoder;

use super::LogProblem;

/// The first bytes of every gzip file (RFC 1952).
const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];

/// A CSV file whose header has been read and whose rows have not.
pub struct LogTable<R> {
    reader: csv::Reader<R>,
    names: Vec<String>,
    /// That of the header, from 1.
    line: u64,
}

impl LogTable<Box<dyn Read>> {
    /// Opens a file, plain or gzipped (told by its first bytes, not by its name).
    ///
    /// # Errors
    /// [`LogProblem`] when there is no header to be read.
    pub fn open(path: &Path) -> Result<Self, LogProblem> {
        let file = File::open(path).map_err(LogProblem::Io)?;
        if file.metadata().map_err(LogProblem::Io)?.is_dir() {
            return Err(LogProblem::Directory);
        }
        let mut reader = BufReader::new(file);
        let start = reader.fill_buf().map_err(LogProblem::Io)?;
        Self::new(if start.starts_with(&GZIP_MAGIC) {
            Box::new(MultiGzDecoder::new(reader))
        } else {
            Box::new(reader)
        })
    }
}

impl<R: Read> LogTable<R> {
    /// Reads the header of a text. Lines that begin with `#` are skipped: loggers like to
    /// note their settings.
    ///
    /// # Errors
    /// [`LogProblem`] when there is none.
    pub fn new(text: R) -> Result<Self, LogProblem> {
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .comment(Some(b'#'))
            .from_reader(text);
        let header = reader.headers().map_err(|error| problem(error, 1))?;
        // A spreadsheet may put a byte-order mark before the first name.
        let names = header
            .iter()
            .map(|name| name.trim_start_matches('\u{feff}'));
        let names: Vec<String> = names.map(String::from).collect();
        if names.iter().all(String::is_empty) {
            return Err(LogProblem::Empty);
        }
        // The reader stands behind the header; comments may stand before it.
        let line = reader.position().line().saturating_sub(1);
        Ok(Self {
            reader,
            names,
            line,
        })
    }

    /// The names of the columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The index of the column of that name.
    ///
    /// # Errors
    /// [`LogProblem::MissingColumn`] or [`LogProblem::AmbiguousColumn`].
    pub fn find(&self, column: &str) -> Result<usize, LogProblem> {
        let names = self.names.iter().enumerate();
        let mut matches = names.filter(|(_, name)| *name == column);
        match (matches.next(), matches.next()) {
            (Some((index, _)), None) => Ok(index),
            (Some(_), Some(_)) => Err(LogProblem::AmbiguousColumn {
                line: self.line,
                column: column.into(),
            }),
            (None, _) => Err(LogProblem::MissingColumn {
                line: self.line,
                column: column.into(),
                found: self.names.join(", "),
            }),
        }
    }

    /// Reads all rows: the numbers of each of the `wanted` columns, by index, times its
    /// factor.
    ///
    /// # Errors
    /// [`LogProblem`] naming line and column.
    pub fn read(mut self, wanted: &[(usize, f64)]) -> Result<Vec<Vec<f64>>, LogProblem> {
        let mut values = vec![Vec::new(); wanted.len()];
        let mut row = StringRecord::new();
        loop {
            let line = self.reader.position().line();
            let more = self.reader.read_record(&mut row);
            if !more.map_err(|error| problem(error, line))? {
                break;
            }
            let line = row.position().map_or(line, csv::Position::line);
            for ((index, factor), column) in wanted.iter().zip(&mut values) {
                let text = row.get(*index).unwrap_or_default();
                let number = text.parse::<f64>().map(|number| number * factor).ok();
                let number = number.filter(|number| number.is_finite());
                column.push(number.ok_or_else(|| LogProblem::NotANumber {
                    line,
                    column: self.names[*index].clone(),
                    text: text.into(),
                })?);
            }
        }
        if values.iter().any(Vec::is_empty) {
            return Err(LogProblem::NoSamples);
        }
        Ok(values)
    }
}

/// What a failure of the CSV reader at `line` means.
fn problem(error: csv::Error, line: u64) -> LogProblem {
    match error.into_kind() {
        ErrorKind::Io(source) => match source.kind() {
            // What the gzip decoder reports for data cut short or damaged.
            io::ErrorKind::UnexpectedEof
            | io::ErrorKind::InvalidInput
            | io::ErrorKind::InvalidData => LogProblem::Gzip { line, source },
            _ => LogProblem::Io(source),
        },
        ErrorKind::UnequalLengths {
            pos,
            expected_len,
            len,
        } => LogProblem::RowLength {
            line: pos.map_or(line, |pos| pos.line()),
            fields: len,
            expected: expected_len,
        },
        ErrorKind::Utf8 { pos, .. } => LogProblem::NotText {
            line: pos.map_or(line, |pos| pos.line()),
        },
        other => LogProblem::Io(io::Error::other(format!("{other:?}"))),
    }
}
