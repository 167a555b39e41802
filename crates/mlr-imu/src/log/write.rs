//! Writing logs.

use std::{
    io::{self, BufWriter, Write},
    path::Path,
};

use flate2::{Compression, write::GzEncoder};
use mlr_filter::OrientationSeries;

use super::{LogError, LogProblem};
use crate::NewFile;

/// Writes time, roll, pitch and yaw under this project's column names, gzipped
/// when the name ends in `.gz`. Numbers are written so that reading gives the
/// same bits back.
///
/// The file appears under its name only when it is complete.
///
/// # Errors
/// [`LogProblem::Exists`] when there is a file of that name, which stays as it
/// is; [`LogProblem::Io`] when the log cannot be written.
pub fn write_log(path: &Path, log: &OrientationSeries) -> Result<(), LogError> {
    write(path, log).map_err(|error| LogError {
        path: path.into(),
        problem: match error.kind() {
            io::ErrorKind::AlreadyExists => LogProblem::Exists,
            _ => LogProblem::Io(error),
        },
    })
}

fn write(path: &Path, log: &OrientationSeries) -> io::Result<()> {
    let zipped = path.extension().is_some_and(|extension| extension == "gz");
    NewFile::reserve(path)?.write(|file| {
        let mut file = BufWriter::new(file);
        if zipped {
            let mut encoder = GzEncoder::new(&mut file, Compression::default());
            write_log_to(&mut encoder, log)?;
            encoder.finish()?;
        } else {
            write_log_to(&mut file, log)?;
        }
        file.flush()
    })?;
    Ok(())
}

/// Writes time, roll, pitch and yaw as CSV, like [`write_log`].
///
/// # Errors
/// When the text cannot be written.
pub fn write_log_to(text: &mut impl Write, log: &OrientationSeries) -> io::Result<()> {
    writeln!(text, "t_s,roll_rad,pitch_rad,yaw_rad")?;
    let angles = log.angles_rad();
    for (index, time_s) in log.times_s().iter().enumerate() {
        let (roll, pitch, yaw) = (angles.roll[index], angles.pitch[index], angles.yaw[index]);
        writeln!(text, "{time_s},{roll},{pitch},{yaw}")?;
    }
    Ok(())
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
            name in prop::sample::select(vec!["log.csv", "log.csv.gz"]),
        ) {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join(name);
            write_log(&path, &log(&values)).unwrap();
            let read = read_log(&path, &Columns::default()).unwrap();
            prop_assert_eq!(read.orientation, log(&values));
        }
    }
}
