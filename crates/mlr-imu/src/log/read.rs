//! Reading logs.

use std::{
    fs::File,
    io::{self, BufReader, Read},
    path::Path,
};

use csv::{ErrorKind, StringRecord};
use flate2::bufread::MultiGzDecoder;
use mlr_filter::{Axes, OrientationSeries};

use super::{Columns, LogError, LogProblem, columns::Column};

/// The first bytes of every gzip file (RFC 1952).
const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];

/// Reads time, roll, pitch and yaw from a CSV file, plain or gzipped (told by
/// its first bytes, not by its name). Other columns are ignored. Time stamps
/// are taken as they are.
///
/// # Errors
/// [`LogError`] naming file and, where it applies, line and column.
pub fn read_log(path: &Path, columns: &Columns) -> Result<OrientationSeries, LogError> {
    open(path)
        .and_then(|text| parse(text, columns))
        .map_err(|problem| LogError {
            path: path.into(),
            problem,
        })
}

fn open(path: &Path) -> Result<Box<dyn Read>, LogProblem> {
    let file = File::open(path).map_err(LogProblem::Io)?;
    if file.metadata().map_err(LogProblem::Io)?.is_dir() {
        return Err(LogProblem::Directory);
    }
    let mut reader = BufReader::new(file);
    let is_gzip = io::BufRead::fill_buf(&mut reader)
        .map_err(LogProblem::Io)?
        .starts_with(&GZIP_MAGIC);
    Ok(if is_gzip {
        Box::new(MultiGzDecoder::new(reader))
    } else {
        Box::new(reader)
    })
}

fn parse(text: impl Read, columns: &Columns) -> Result<OrientationSeries, LogProblem> {
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        // Loggers like to note their settings above the header.
        .comment(Some(b'#'))
        .from_reader(text);
    let header = reader.headers().map_err(|error| problem(error, 1))?.clone();
    if header.iter().all(str::is_empty) {
        return Err(LogProblem::Empty);
    }
    // The reader stands behind the header; comments may stand before it.
    let line = reader.position().line().saturating_sub(1);
    let wanted = [
        Field::find(&header, line, &columns.time)?,
        Field::find(&header, line, &columns.roll)?,
        Field::find(&header, line, &columns.pitch)?,
        Field::find(&header, line, &columns.yaw)?,
    ];
    let mut values = [const { Vec::new() }; 4];
    let mut row = StringRecord::new();
    loop {
        let line = reader.position().line();
        if !reader
            .read_record(&mut row)
            .map_err(|error| problem(error, line))?
        {
            break;
        }
        let line = row.position().map_or(line, csv::Position::line);
        for (field, column) in wanted.iter().zip(&mut values) {
            column.push(field.number(&row, line)?);
        }
    }
    let [times_s, roll, pitch, yaw] = values;
    if times_s.is_empty() {
        return Err(LogProblem::NoSamples);
    }
    Ok(OrientationSeries::new(times_s, Axes { roll, pitch, yaw })
        .expect("every row gave one finite number per column"))
}

/// Where a column is in a row.
struct Field<'a> {
    index: usize,
    column: &'a Column,
}

impl<'a> Field<'a> {
    fn find(header: &StringRecord, line: u64, column: &'a Column) -> Result<Self, LogProblem> {
        // A spreadsheet may put a byte-order mark before the first name.
        let mut matches = header
            .iter()
            .enumerate()
            .filter(|(_, name)| name.trim_start_matches('\u{feff}') == column.name)
            .map(|(index, _)| index);
        match (matches.next(), matches.next()) {
            (Some(index), None) => Ok(Self { index, column }),
            (Some(_), Some(_)) => Err(LogProblem::AmbiguousColumn {
                line,
                column: column.name.clone(),
            }),
            (None, _) => Err(LogProblem::MissingColumn {
                line,
                column: column.name.clone(),
                found: header.iter().collect::<Vec<_>>().join(", "),
            }),
        }
    }

    fn number(&self, row: &StringRecord, line: u64) -> Result<f64, LogProblem> {
        let text = row.get(self.index).unwrap_or_default();
        text.parse::<f64>()
            .map(|value| value * self.column.scale)
            .ok()
            .filter(|value| value.is_finite())
            .ok_or_else(|| LogProblem::NotANumber {
                line,
                column: self.column.name.clone(),
                text: text.into(),
            })
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

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::{Compression, write::GzEncoder};

    use super::*;

    fn read(text: &str) -> Result<OrientationSeries, LogProblem> {
        parse(text.as_bytes(), &Columns::default())
    }

    fn message(text: &str) -> String {
        read(text).unwrap_err().to_string()
    }

    const HEADER: &str = "t_s,roll_rad,pitch_rad,yaw_rad\n";

    #[test]
    fn columns_are_found_by_name_in_any_order() {
        let log = read("extra,yaw_rad,t_s,pitch_rad,roll_rad\nx,4,1,3,2\n").unwrap();
        assert_eq!(log.times_s(), [1.0]);
        assert_eq!(log.angles_rad().roll, [2.0]);
        assert_eq!(log.angles_rad().pitch, [3.0]);
        assert_eq!(log.angles_rad().yaw, [4.0]);
    }

    #[test]
    fn windows_line_ends_spaces_and_byte_order_mark_are_fine() {
        let log = read("\u{feff}t_s, roll_rad, pitch_rad, yaw_rad\r\n0, 1, 2, 3\r\n").unwrap();
        assert_eq!(log.angles_rad().yaw, [3.0]);
    }

    #[test]
    fn comments_above_the_header_are_skipped_and_counted() {
        let log = read(&format!("# 80 Hz\n{HEADER}0,1,2,3\n")).unwrap();
        assert_eq!(log.angles_rad().roll, [1.0]);
        let message = message("# 80 Hz\nt,roll_rad,pitch_rad,yaw_rad\n0,1,2,3\n");
        assert!(
            message.starts_with("line 2: no column \"t_s\""),
            "{message}"
        );
    }

    #[test]
    fn nothing_and_header_only_are_told_apart() {
        assert!(matches!(read(""), Err(LogProblem::Empty)));
        assert!(matches!(read(HEADER), Err(LogProblem::NoSamples)));
    }

    #[test]
    fn a_missing_column_is_named_with_those_that_are_there() {
        let message = message("t_s,roll_rad,yaw_rad\n0,0,0\n");
        assert!(message.contains("\"pitch_rad\""), "{message}");
        assert!(message.contains("t_s, roll_rad, yaw_rad"), "{message}");
        assert!(matches!(
            read("t_s,t_s,roll_rad,pitch_rad,yaw_rad\n0,0,0,0,0\n"),
            Err(LogProblem::AmbiguousColumn { .. })
        ));
    }

    #[test]
    fn text_and_nan_in_a_number_name_line_and_column() {
        for bad in ["oops", "NaN", "inf", "", "1,5"] {
            let text = format!("{HEADER}0,0,0,0\n1,\"{bad}\",0,0\n");
            let message = message(&text);
            assert!(message.contains("line 3"), "{message}");
            assert!(message.contains("\"roll_rad\""), "{message}");
            assert!(message.contains(&format!("{bad:?}")), "{message}");
        }
    }

    #[test]
    fn a_short_row_names_its_line() {
        let message = message(&format!("{HEADER}0,0,0,0\n1,0,0\n"));
        assert!(
            message.contains("line 3: 3 fields, expected 4"),
            "{message}"
        );
    }

    #[test]
    fn bytes_that_are_no_text_name_their_line() {
        let mut bytes = HEADER.as_bytes().to_vec();
        bytes.extend(b"0,\xff\xfe,0,0\n");
        let problem = parse(bytes.as_slice(), &Columns::default()).unwrap_err();
        assert!(
            matches!(problem, LogProblem::NotText { line: 2 }),
            "{problem}"
        );
    }

    #[test]
    fn gzip_is_recognised_by_content_and_truncation_is_said() {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(HEADER.as_bytes()).unwrap();
        for i in 0..10_000 {
            writeln!(encoder, "{i},0.1,0.2,0.{i}").unwrap();
        }
        let compressed = encoder.finish().unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        std::fs::write(&path, &compressed).unwrap();
        assert_eq!(read_log(&path, &Columns::default()).unwrap().len(), 10_000);

        for keep in [compressed.len() / 2, compressed.len() - 4, 5] {
            std::fs::write(&path, &compressed[..keep]).unwrap();
            let error = read_log(&path, &Columns::default()).unwrap_err();
            assert!(matches!(error.problem, LogProblem::Gzip { .. }), "{error}");
        }
    }

    #[test]
    fn a_directory_is_no_log() {
        let folder = tempfile::tempdir().unwrap();
        let error = read_log(folder.path(), &Columns::default()).unwrap_err();
        assert!(matches!(error.problem, LogProblem::Directory), "{error}");
    }
}
