//! Reading logs.

use std::{io::Read, path::Path};

use mlr_filter::{Axes, OrientationSeries};
use nalgebra::Vector3;

use super::{Columns, LogError, LogProblem, LogTable, columns::Column};
use crate::{OrientationSource, RawSeries, Recording};

/// Reads a CSV file, plain or gzipped (told by its first bytes, not by its name): roll,
/// pitch and yaw over time, and the six raw columns of accelerometer and gyroscope.
/// Either may be missing; raw samples without angles are fused ([`RawSeries::fuse`]).
/// Other columns are ignored. Time stamps are taken as they are.
///
/// # Errors
/// [`LogError`] naming file and, where it applies, line and column.
pub fn read_log(path: &Path, columns: &Columns) -> Result<Recording, LogError> {
    LogTable::open(path)
        .and_then(|table| parse(table, columns))
        .map_err(|problem| LogError {
            path: path.into(),
            problem,
        })
}

fn vectors(x: Vec<f64>, y: Vec<f64>, z: Vec<f64>) -> Vec<Vector3<f64>> {
    let yz = y.into_iter().zip(z);
    x.into_iter()
        .zip(yz)
        .map(|(x, (y, z))| Vector3::new(x, y, z))
        .collect()
}

fn parse(table: LogTable<impl Read>, columns: &Columns) -> Result<Recording, LogProblem> {
    let [roll, pitch, yaw] = &columns.angles;
    let [ax, ay, az, gx, gy, gz] = &columns.raw;
    let time = &columns.time;
    let has_raw = has_all(&table, &columns.raw);
    let has_angle = columns.angles.iter().any(|c| table.find(&c.name).is_ok());
    if has_raw && !has_angle {
        let wanted = [time, ax, ay, az, gx, gy, gz];
        let [times_s, ax, ay, az, gx, gy, gz] = read_columns(table, wanted)?;
        let raw = RawSeries {
            times_s,
            accelerations_mps2: vectors(ax, ay, az),
            angular_rates_radps: vectors(gx, gy, gz),
        };
        return Ok(Recording {
            orientation: raw.clone().fuse()?,
            raw: Some(raw),
            source: OrientationSource::Fused,
            columns: columns.clone(),
            in_body_axes: false,
            notes: Vec::new(),
        });
    }
    if !has_raw {
        let [times_s, roll, pitch, yaw] = read_columns(table, [time, roll, pitch, yaw])?;
        let orientation = OrientationSeries::new(times_s, Axes { roll, pitch, yaw })?;
        return Ok(Recording {
            columns: columns.clone(),
            ..orientation.into()
        });
    }
    let wanted = [time, roll, pitch, yaw, ax, ay, az, gx, gy, gz];
    let [times_s, roll, pitch, yaw, ax, ay, az, gx, gy, gz] = read_columns(table, wanted)?;
    let raw = RawSeries {
        times_s: times_s.clone(),
        accelerations_mps2: vectors(ax, ay, az),
        angular_rates_radps: vectors(gx, gy, gz),
    };
    Ok(Recording {
        orientation: OrientationSeries::new(times_s, Axes { roll, pitch, yaw })?,
        raw: Some(raw),
        source: OrientationSource::Recorded,
        columns: columns.clone(),
        in_body_axes: false,
        notes: Vec::new(),
    })
}

fn has_all(table: &LogTable<impl Read>, columns: &[Column]) -> bool {
    columns
        .iter()
        .all(|column| table.find(&column.name).is_ok())
}

/// The numbers of the wanted columns in their units.
fn read_columns<const N: usize>(
    table: LogTable<impl Read>,
    wanted: [&Column; N],
) -> Result<[Vec<f64>; N], LogProblem> {
    let scaled = wanted
        .into_iter()
        .map(|column| Ok((table.find(&column.name)?, column.scale)))
        .collect::<Result<Vec<_>, LogProblem>>()?;
    let mut values = table.read(&scaled)?.into_iter();
    Ok([(); N].map(|()| values.next().unwrap_or_default()))
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::{Compression, write::GzEncoder};

    use super::*;

    fn read(text: &str) -> Result<OrientationSeries, LogProblem> {
        parse(LogTable::new(text.as_bytes())?, &Columns::default())
            .map(|recording| recording.orientation)
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
        let table = LogTable::new(bytes.as_slice()).unwrap();
        let problem = parse(table, &Columns::default()).unwrap_err();
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
