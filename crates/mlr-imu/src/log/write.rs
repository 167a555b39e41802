//! Writing logs.

use std::{
    io::{self, BufWriter, Write},
    path::Path,
};

use flate2::{Compression, write::GzEncoder};
use mlr_filter::OrientationSeries;
use tempfile::NamedTempFile;

use super::{LogError, LogProblem};

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
    write(path, log).map_err(|problem| LogError {
        path: path.into(),
        problem,
    })
}

fn write(path: &Path, log: &OrientationSeries) -> Result<(), LogProblem> {
    if path.exists() {
        return Err(LogProblem::Exists);
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut file = temporary_file_in(folder).map_err(LogProblem::Io)?;
    if path.extension().is_some_and(|extension| extension == "gz") {
        let mut encoder = GzEncoder::new(BufWriter::new(&mut file), Compression::default());
        write_rows(&mut encoder, log)
            .and_then(|()| encoder.finish())
            .and_then(|mut text| text.flush())
            .map_err(LogProblem::Io)?;
    } else {
        let mut text = BufWriter::new(&mut file);
        write_rows(&mut text, log)
            .and_then(|()| text.flush())
            .map_err(LogProblem::Io)?;
    }
    file.persist_noclobber(path)
        .map_err(|failure| match failure.error.kind() {
            io::ErrorKind::AlreadyExists => LogProblem::Exists,
            _ => LogProblem::Io(failure.error),
        })?;
    Ok(())
}

/// A file that others may read as far as the user's umask lets them, like any
/// new file (a temporary file's own default is private).
fn temporary_file_in(folder: &Path) -> io::Result<NamedTempFile> {
    #[cfg_attr(not(unix), allow(unused_mut, reason = "only Unix has modes"))]
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

fn write_rows(text: &mut impl Write, log: &OrientationSeries) -> io::Result<()> {
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
            prop_assert_eq!(read_log(&path, &Columns::default()).unwrap(), log(&values));
        }
    }
}
