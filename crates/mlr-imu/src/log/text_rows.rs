//! The rows of a text.

use std::io::Read;

use super::{
    LogColumn, LogLimits, LogProblem, LogValues, Place,
    excerpt::shortened,
    fields::{Delimiter, Fields, Splitter},
    lines::Lines,
    number::{Numbers, decimals},
    skipped_rows::SkippedRows,
    stream::IN_BODY_AXES,
    table::Holds,
    time_stamp::TimeStamps,
};

/// The first line of tables that a spreadsheet is to open, as in `sep=;`.
const SPREADSHEET_HINT: &[u8] = b"sep=";
/// Rows from which on the last number of the last one can be compared with those before.
const MANY_ROWS: usize = 20;

/// A text whose header has been read and whose rows have not.
pub(super) struct TextRows<R> {
    lines: Lines<R>,
    splitter: Splitter,
    limits: LogLimits,
    numbers: Numbers,
}

/// What stands above the rows.
pub(super) struct TextHeader {
    pub(super) names: Vec<String>,
    /// Its line, from 1.
    pub(super) line: u64,
    /// Whether a comment says so.
    pub(super) in_body_axes: bool,
}

impl<R: Read> TextRows<R> {
    /// Reads the header of a text.
    ///
    /// # Errors
    /// [`LogProblem`] when there is none.
    pub(super) fn new(text: R, limits: LogLimits) -> Result<(Self, TextHeader), LogProblem> {
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
        let rows = Self {
            lines,
            splitter,
            limits,
            numbers: Numbers::new(delimiter.leaves_commas_to_numbers()),
        };
        let header = TextHeader {
            names,
            line,
            in_body_axes,
        };
        Ok((rows, header))
    }

    /// Reads all rows; one that does not pass the check counts as one that cannot be read.
    pub(super) fn read(
        mut self,
        names: &[String],
        wanted: &[LogColumn],
        check: impl Fn(&Place, &[f64]) -> Result<(), LogProblem>,
    ) -> Result<LogValues, LogProblem> {
        let mut columns = vec![Vec::new(); wanted.len()];
        let mut row = RowReader::new(wanted, names, self.numbers);
        let mut skipped = SkippedRows::new(self.limits);
        let mut notes = Vec::new();
        while let Some(line) = self.lines.next()? {
            if is_no_row(line.text) {
                continue;
            }
            let place = Place::Line(line.number);
            skipped.begin_row(&place)?;
            let begun = columns.first().map_or(0, Vec::len);
            let fields = self.splitter.split(line.text);
            let fields = fields.ok_or(LogProblem::TooManyColumns {
                line: line.number,
                max_columns: self.limits.max_columns,
            })?;
            let problem = row
                .read(line.number, fields)
                .and_then(|()| check(&place, &row.values))
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
                    place: Place::Line(line),
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
