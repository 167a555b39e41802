//! Writing logs.

use std::{
    io::{self, BufWriter, Write},
    path::Path,
};

use flate2::{Compression, write::GzEncoder};
use mlr_filter::{Axes, OrientationSeries};

use super::{IN_BODY_AXES, LogError, LogProblem, McapBegin, McapStream};
use crate::{ImuSample, NewFile, OrientationSource, RawSeries, Recording};

/// The first line of what is in the body's axes begins with this.
const WRITER: &str = concat!("mlr ", env!("CARGO_PKG_VERSION"));

/// How a log is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LogFormat {
    /// Text, numbers separated by commas.
    Csv,
    /// The same, gzipped.
    CsvGz,
    /// MCAP with `sensor_msgs/msg/Imu` of ROS 2.
    Mcap,
}

impl LogFormat {
    /// The format that a file's name ends in.
    pub fn of_name(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_str()?.to_ascii_lowercase();
        [
            (".csv", Self::Csv),
            (".csv.gz", Self::CsvGz),
            (".mcap", Self::Mcap),
        ]
        .into_iter()
        .find(|(ending, _)| name.ends_with(ending))
        .map(|(_, format)| format)
    }
}

/// Writes time, roll, pitch and yaw, as MCAP when the name ends in `.mcap`, else as CSV under this
/// project's column names, gzipped when it ends in `.gz`. Numbers of CSV are written so that
/// reading gives the same bits back.
///
/// The file appears under its name only when it is complete.
///
/// # Errors
/// [`LogProblem::Exists`] when there is a file of that name, which stays as it
/// is; [`LogProblem::Io`] when the log cannot be written.
pub fn write_log(path: &Path, log: &OrientationSeries) -> Result<(), LogError> {
    let zipped = path.extension().is_some_and(|extension| extension == "gz");
    let format = LogFormat::of_name(path).unwrap_or(match zipped {
        true => LogFormat::CsvGz,
        false => LogFormat::Csv,
    });
    write(path, format, &Rows::of_angles(log), 0)
}

/// Writes what a sensor recorded: time, the orientation where it was recorded too, and the raw
/// samples, in the format that the name ends in. The log's time zero is `begin_ns` after 1970,
/// which only MCAP can hold.
///
/// The file appears under its name only when it is complete.
///
/// # Errors
/// [`LogProblem::UnknownFormat`], [`LogProblem::Exists`] when there is a file of that name, which
/// stays as it is; [`LogProblem::Io`] when the log cannot be written.
pub fn write_recording(path: &Path, recording: &Recording, begin_ns: i64) -> Result<(), LogError> {
    let format = LogFormat::of_name(path).ok_or_else(|| LogError {
        path: path.into(),
        problem: LogProblem::UnknownFormat,
    })?;
    write(path, format, &Rows::of(recording), begin_ns)
}

/// Writes time, roll, pitch and yaw as CSV, like [`write_log`].
///
/// # Errors
/// When the text cannot be written.
pub fn write_log_to(text: &mut impl Write, log: &OrientationSeries) -> io::Result<()> {
    Rows::of_angles(log).write_csv(text)
}

fn write(path: &Path, format: LogFormat, rows: &Rows<'_>, begin_ns: i64) -> Result<(), LogError> {
    let written = NewFile::reserve(path).and_then(|new| {
        new.write(|file| {
            let mut file = BufWriter::new(file);
            match format {
                LogFormat::Csv => rows.write_csv(&mut file)?,
                LogFormat::CsvGz => {
                    let mut encoder = GzEncoder::new(&mut file, Compression::default());
                    rows.write_csv(&mut encoder)?;
                    encoder.finish()?;
                }
                LogFormat::Mcap => rows.write_mcap(&mut file, begin_ns)?,
            }
            file.flush()
        })
    });
    match written {
        Ok(_) => Ok(()),
        Err(error) => Err(LogError {
            path: path.into(),
            problem: match error.kind() {
                io::ErrorKind::AlreadyExists => LogProblem::Exists,
                _ => LogProblem::Io(error),
            },
        }),
    }
}

/// What a log holds of each moment.
struct Rows<'a> {
    times_s: &'a [f64],
    angles_rad: Option<&'a Axes<Vec<f64>>>,
    raw: Option<&'a RawSeries>,
    in_body_axes: bool,
}

impl<'a> Rows<'a> {
    fn of_angles(log: &'a OrientationSeries) -> Self {
        Self {
            times_s: log.times_s(),
            angles_rad: Some(log.angles_rad()),
            raw: None,
            in_body_axes: false,
        }
    }

    fn of(recording: &'a Recording) -> Self {
        let is_recorded = recording.source == OrientationSource::Recorded;
        let angles_rad = recording.orientation.angles_rad();
        Self {
            times_s: recording.orientation.times_s(),
            angles_rad: is_recorded.then_some(angles_rad),
            raw: recording.raw.as_ref(),
            in_body_axes: recording.in_body_axes,
        }
    }

    fn angles_rad(&self, index: usize) -> Option<Axes<f64>> {
        self.angles_rad.map(|angles| Axes {
            roll: angles.roll[index],
            pitch: angles.pitch[index],
            yaw: angles.yaw[index],
        })
    }

    fn write_csv(&self, text: &mut impl Write) -> io::Result<()> {
        if self.in_body_axes {
            writeln!(text, "# {WRITER}{IN_BODY_AXES}")?;
        }
        write!(text, "t_s")?;
        if self.angles_rad.is_some() {
            write!(text, ",roll_rad,pitch_rad,yaw_rad")?;
        }
        if self.raw.is_some() {
            write!(text, ",ax_mps2,ay_mps2,az_mps2,gx_radps,gy_radps,gz_radps")?;
        }
        writeln!(text)?;
        for (index, time_s) in self.times_s.iter().enumerate() {
            write!(text, "{time_s}")?;
            if let Some(Axes { roll, pitch, yaw }) = self.angles_rad(index) {
                write!(text, ",{roll},{pitch},{yaw}")?;
            }
            if let Some(raw) = self.raw {
                for v in [
                    &raw.accelerations_mps2[index],
                    &raw.angular_rates_radps[index],
                ] {
                    write!(text, ",{},{},{}", v.x, v.y, v.z)?;
                }
            }
            writeln!(text)?;
        }
        Ok(())
    }

    fn write_mcap(&self, file: &mut impl Write, begin_ns: i64) -> io::Result<()> {
        let begin = McapBegin {
            library: WRITER,
            begin_ns,
            in_body_axes: self.in_body_axes,
            has_orientations: self.angles_rad.is_some(),
            chunked: true,
        };
        let mut stream = McapStream::new(file, &begin)?;
        for (index, time_s) in self.times_s.iter().enumerate() {
            let sample = ImuSample {
                acceleration_mps2: self.raw.map(|raw| raw.accelerations_mps2[index]),
                angular_rate_radps: self.raw.map(|raw| raw.angular_rates_radps[index]),
                ..ImuSample::default()
            };
            stream.write(*time_s, self.angles_rad(index).as_ref(), &sample)?;
        }
        stream.finish()
    }
}

#[cfg(test)]
mod tests {
    use mlr_filter::Axes;
    use proptest::prelude::*;

    use super::*;
    use crate::{Columns, read_log};

    fn log(values: &[f64]) -> OrientationSeries {
        let times_s = (0..values.len()).map(|i| i as f64 * 0.001).collect();
        OrientationSeries::new(times_s, Axes::from_fn(|_| values.to_vec())).unwrap()
    }

    #[test]
    fn an_existing_file_is_left_as_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.csv");
        std::fs::write(&path, "precious").unwrap();
        let error = write_log(&path, &log(&[0.0])).unwrap_err();
        assert!(matches!(error.problem, LogProblem::Exists));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "precious");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn what_is_written_is_read_back_bit_for_bit(
            values in prop::collection::vec(-1e3..1e3_f64, 1..50),
            name in prop::sample::select(vec!["log.csv", "log.csv.gz", "log"]),
        ) {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join(name);
            write_log(&path, &log(&values)).unwrap();
            let read = read_log(&path, &Columns::default()).unwrap();
            prop_assert_eq!(read.orientation, log(&values));
        }
    }
}
