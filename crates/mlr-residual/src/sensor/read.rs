//! Reading a sensor's log.

use std::{
    fs::File,
    io::{self, BufRead, BufReader, Read},
    path::Path,
};

use csv::{ErrorKind, StringRecord};
use flate2::bufread::MultiGzDecoder;
use mlr_imu::{LogError, LogProblem};

use super::{SensorColumns, SensorSignals, columns::Siblings};

/// The first bytes of every gzip file (RFC 1952).
const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];

/// Reads a gyroscope's signals and the angle in degrees measured beside it from a
/// CSV file, plain or gzipped. The sensor's other rates, accelerations and
/// temperature are read where their names tell that they belong to it:
/// `g2y_dps`, `g2z_dps`, `a2x_g`, `a2y_g` and `a2z_g` beside `g2x_dps`, and
/// `temperature_c`. Time stamps are taken as they are.
///
/// # Errors
/// [`LogError`] naming file and, where it applies, line and column.
pub fn read_sensor_log(
    path: &Path,
    columns: &SensorColumns,
) -> Result<(SensorSignals, Vec<f64>), LogError> {
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
    let start = reader.fill_buf().map_err(LogProblem::Io)?;
    Ok(if start.starts_with(&GZIP_MAGIC) {
        Box::new(MultiGzDecoder::new(reader))
    } else {
        Box::new(reader)
    })
}

fn parse(
    text: impl Read,
    columns: &SensorColumns,
) -> Result<(SensorSignals, Vec<f64>), LogProblem> {
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        // Loggers like to note their settings above the header.
        .comment(Some(b'#'))
        .from_reader(text);
    let header = reader.headers().map_err(|error| problem(error, 1))?.clone();
    // A spreadsheet may put a byte-order mark before the first name.
    let names: Vec<&str> = header
        .iter()
        .map(|name| name.trim_start_matches('\u{feff}'))
        .collect();
    if names.iter().all(|name| name.is_empty()) {
        return Err(LogProblem::Empty);
    }
    // The reader stands behind the header; comments may stand before it.
    let line = reader.position().line().saturating_sub(1);
    let siblings = Siblings::find(&names, &columns.rate.0);
    let mut wanted = vec![
        (find(&names, line, &columns.time.0)?, columns.time.1.to_s()),
        (
            find(&names, line, &columns.rate.0)?,
            columns.rate.1.to_dps() * columns.sign,
        ),
        (
            find(&names, line, &columns.angle.0)?,
            columns.angle.1.to_deg(),
        ),
    ];
    let rate_scale = columns.rate.1.to_dps();
    wanted.extend(siblings.cross.iter().map(|(_, index)| (*index, rate_scale)));
    if let Some((indices, scale)) = siblings.accelerations {
        wanted.extend(indices.map(|index| (index, scale)));
    }
    wanted.extend(siblings.temperature.map(|index| (index, 1.0)));

    let mut values = read_columns(reader, &names, &wanted)?.into_iter();
    let mut next = || values.next().unwrap_or_default();
    let (times_s, rate_dps, angle_deg) = (next(), next(), next());
    let cross_rates_dps = siblings.cross.iter().map(|(axis, _)| (*axis, next()));
    let cross_rates_dps = cross_rates_dps.collect();
    let accelerations_g = siblings.accelerations.map(|_| [next(), next(), next()]);
    let signals = SensorSignals {
        sign: columns.sign,
        axis: siblings.axis,
        cross_rates_dps,
        accelerations_g,
        temperature_c: siblings.temperature.map(|_| next()),
        ..SensorSignals::new(times_s, rate_dps)
    };
    Ok((signals, angle_deg))
}

fn find(names: &[&str], line: u64, column: &str) -> Result<usize, LogProblem> {
    let mut matches = names
        .iter()
        .enumerate()
        .filter(|(_, name)| **name == column);
    match (matches.next(), matches.next()) {
        (Some((index, _)), None) => Ok(index),
        (Some(_), Some(_)) => Err(LogProblem::AmbiguousColumn {
            line,
            column: column.into(),
        }),
        (None, _) => Err(LogProblem::MissingColumn {
            line,
            column: column.into(),
            found: names.join(", "),
        }),
    }
}

/// The numbers of the columns at the indices `wanted`, times their scales.
fn read_columns(
    mut reader: csv::Reader<impl Read>,
    names: &[&str],
    wanted: &[(usize, f64)],
) -> Result<Vec<Vec<f64>>, LogProblem> {
    let mut values = vec![Vec::new(); wanted.len()];
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
        for ((index, scale), column) in wanted.iter().zip(&mut values) {
            let text = row.get(*index).unwrap_or_default();
            let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
            let number = number.ok_or_else(|| LogProblem::NotANumber {
                line,
                column: names[*index].into(),
                text: text.into(),
            })?;
            column.push(number * scale);
        }
    }
    if values.iter().any(Vec::is_empty) {
        return Err(LogProblem::NoSamples);
    }
    Ok(values)
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
    use super::*;
    use crate::{AngleUnit, RateUnit, TimeUnit};

    fn columns() -> SensorColumns {
        SensorColumns {
            time: ("t".into(), TimeUnit::Milliseconds),
            rate: ("gx_radps".into(), RateUnit::RadiansPerSecond),
            angle: ("encoder".into(), AngleUnit::Degrees),
            sign: -1.0,
        }
    }

    #[test]
    fn units_and_sign_are_applied_when_the_log_is_read() {
        let text = "\u{feff}encoder,gx_radps,t\r\n90,0.5,250\r\n";
        let (signals, angle_deg) = parse(text.as_bytes(), &columns()).unwrap();
        assert_eq!(angle_deg, [90.0]);
        assert_eq!(signals.times_s, [0.25]);
        assert!((signals.rate_dps[0] + 28.647_889_756_5).abs() < 1e-9);
        assert!(signals.accelerations_g.is_none());
    }

    #[test]
    fn bad_input_is_named_with_line_and_column() {
        for (text, expected) in [
            (
                "t,gx_radps,encoder\n1,2,3\n1,x,3\n",
                "line 3, column \"gx_radps\": \"x\"",
            ),
            (
                "# 1\nt,gx,encoder\n1,2,3\n",
                "line 2: no column \"gx_radps\"",
            ),
            (
                "t,gx_radps,encoder,t\n1,2,3,4\n",
                "column \"t\" appears more than once",
            ),
            ("t,gx_radps,encoder\n", "no samples"),
            ("t,gx_radps,encoder\n1,2\n", "line 2: 2 fields"),
            ("", "is empty"),
        ] {
            let message = parse(text.as_bytes(), &columns()).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
