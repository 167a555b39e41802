//! Reading logs.

use std::{io::Read, path::Path};

use mlr_filter::Axes;

use super::{
    Columns, LogColumn, LogError, LogLimits, LogProblem, LogTable, angles, columns::Column,
    excerpt::shortened, suggestion,
};
use crate::Recording;

/// Reads a log file within the default [`LogLimits`]: see [`Recording::from_table`].
///
/// # Errors
/// [`LogError`] naming file and, where it applies, line and column.
pub fn read_log(path: impl AsRef<Path>, columns: &Columns) -> Result<Recording, LogError> {
    let path = path.as_ref();
    LogTable::open(path, None, LogLimits::default())
        .and_then(|table| Recording::from_table(table, columns))
        .map_err(|problem| LogError {
            path: path.into(),
            problem,
        })
}

/// Which columns an orientation is read from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Source {
    Angles,
    Quaternion,
    RawSamples,
}

impl Recording {
    /// Reads roll, pitch and yaw over time, and the six raw columns of accelerometer and
    /// gyroscope. Either may be missing. Where there are no angles, they are those of a quaternion,
    /// or fused from the raw samples ([`RawSeries::fuse`](crate::RawSeries::fuse)). Angles that jump by a turn at ±π or 2π
    /// are unwrapped. Other columns are ignored. Time stamps are taken as they are; dates count
    /// from the first.
    ///
    /// # Errors
    /// [`LogProblem`] naming line and column.
    pub fn from_table(table: LogTable<impl Read>, columns: &Columns) -> Result<Self, LogProblem> {
        let in_body_axes = table.is_in_body_axes();
        let has_raw = has_all(&table, &columns.raw);
        let source = source(&table, columns, has_raw);
        let found = |column: &Column| {
            let index = table.find(&column.name);
            index.map_err(|problem| with_hint(problem, columns, table.names()))
        };
        let mut wanted = vec![LogColumn::of_times(
            found(&columns.time)?,
            columns.time.scale,
        )];
        let oriented: &[Column] = match source {
            Source::Angles => &columns.angles,
            Source::Quaternion => &columns.quaternion,
            Source::RawSamples => &columns.raw,
        };
        for column in oriented {
            wanted.push(LogColumn::of_numbers(found(column)?, column.scale));
        }
        let has_raw_beside = has_raw && source != Source::RawSamples;
        if has_raw_beside {
            for column in &columns.raw {
                wanted.push(LogColumn::of_optional_numbers(found(column)?, column.scale));
            }
        }
        let mut notes = notes_on_mapped(&table, columns);
        let norm_is_checked = source == Source::Quaternion;
        let read = table.read_checked(&wanted, |place, row| match *row {
            [_, w, x, y, z, ..] if norm_is_checked => match angles::wrong_norm([w, x, y, z]) {
                None => Ok(()),
                Some(norm) => Err(LogProblem::NotUnitQuaternion {
                    place: place.clone(),
                    columns: names(&columns.quaternion),
                    norm,
                }),
            },
            _ => Ok(()),
        })?;
        notes.extend(read.notes);
        let mut values = read.columns.into_iter();
        let mut next = || values.next().unwrap_or_default();
        let times_s = next();
        let angles_rad = match source {
            Source::Angles => {
                let (roll, pitch, yaw) = (next(), next(), next());
                Some(Axes { roll, pitch, yaw })
            }
            Source::Quaternion => Some(angles::of_quaternions([next(), next(), next(), next()])),
            Source::RawSamples => None,
        };
        let raw = has_raw.then(|| [(); 6].map(|()| next()));
        let recording = Self::from_columns(times_s, angles_rad, raw)?;
        notes.extend(recording.notes);
        Ok(Self {
            columns: columns.clone(),
            in_body_axes,
            notes,
            ..recording
        })
    }
}

fn source(table: &LogTable<impl Read>, columns: &Columns, has_raw: bool) -> Source {
    let has_quaternion = has_all(table, &columns.quaternion);
    let is_mapped = |kind: &[Column]| kind.iter().any(|column| column.is_mapped);
    let has_some_angle = columns
        .angles
        .iter()
        .any(|column| table.find(&column.name).is_ok());
    if has_quaternion && is_mapped(&columns.quaternion) && !is_mapped(&columns.angles) {
        Source::Quaternion
    } else if has_all(table, &columns.angles) {
        Source::Angles
    } else if has_quaternion {
        Source::Quaternion
    } else if has_raw && !has_some_angle {
        Source::RawSamples
    } else {
        Source::Angles
    }
}

fn has_all(table: &LogTable<impl Read>, columns: &[Column]) -> bool {
    columns
        .iter()
        .all(|column| table.find(&column.name).is_ok())
}

/// Tells of columns that a person has mapped and that are not needed, because they are not there.
fn notes_on_mapped(table: &LogTable<impl Read>, columns: &Columns) -> Vec<String> {
    columns
        .all()
        .filter(|column| column.is_mapped && table.find(&column.name).is_err())
        .map(|column| {
            let name = shortened(&column.name);
            format!(
                "--column {}: no column {name:?}; read without it",
                column.key
            )
        })
        .collect()
}

fn names(columns: &[Column]) -> String {
    let names: Vec<_> = columns.iter().map(|c| shortened(&c.name)).collect();
    names.join(", ")
}

/// Adds what to type to the message that a column is missing.
fn with_hint(problem: LogProblem, columns: &Columns, names: &[String]) -> LogProblem {
    match problem {
        LogProblem::MissingColumn {
            place,
            column,
            found,
            hint: near,
        } => {
            let mapping = suggestion::hint(columns, names);
            LogProblem::MissingColumn {
                place,
                column,
                found,
                hint: if mapping.is_empty() {
                    near
                } else {
                    mapping.into()
                },
            }
        }
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::{Compression, write::GzEncoder};
    use mlr_filter::OrientationSeries;

    use super::*;

    fn recorded(text: &str) -> Result<Recording, LogProblem> {
        let table = LogTable::new(text.as_bytes(), LogLimits::default())?;
        Recording::from_table(table, &Columns::default())
    }

    fn read(text: &str) -> Result<OrientationSeries, LogProblem> {
        recorded(text).map(|recording| recording.orientation)
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
    fn raw_columns_are_fused_where_there_is_no_orientation() {
        let raw_header = "t_s,ax_mps2,ay_mps2,az_mps2,gx_radps,gy_radps,gz_radps";
        // At rest with the left side up by 0.1 rad.
        let mut raw = format!("{raw_header}\n");
        let mut both = format!("{raw_header},roll_rad,pitch_rad,yaw_rad\n");
        for i in 0..500 {
            let (ay, az) = (9.81 * 0.1_f64.sin(), 9.81 * 0.1_f64.cos());
            let sample = format!("{},0,{ay},{az},0,0,0", f64::from(i) * 0.01);
            raw += &format!("{sample}\n");
            both += &format!("{sample},1,2,3\n");
        }
        let fused = read(&raw).unwrap();
        let (roll, pitch) = (fused.angles_rad().roll[499], fused.angles_rad().pitch[499]);
        assert!(
            (roll - 0.1).abs() < 2e-4 && pitch.abs() < 2e-4,
            "{roll} {pitch}"
        );
        assert_eq!(read(&both).unwrap().angles_rad().yaw, [3.0; 500]);
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
        let table = LogTable::new(bytes.as_slice(), LogLimits::default()).unwrap();
        let problem = Recording::from_table(table, &Columns::default()).unwrap_err();
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
        let read = read_log(&path, &Columns::default()).unwrap();
        assert_eq!(read.orientation.len(), 10_000);

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
