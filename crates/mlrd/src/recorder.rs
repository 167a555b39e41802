//! Records what the sensor says, bounded in size.

use std::{
    fs::{self, File},
    io::{self, BufRead, BufReader, BufWriter, Read, Write},
    path::{Path, PathBuf},
    time::SystemTime,
};

use mlr_imu::{IN_BODY_AXES, LogStream};

use crate::{sensor::Reading, settings::RecordSettings};

/// Writes readings to CSV files, `walk-TIME.csv`, that `mlr-ga` reads.
///
/// A file that is full is closed and the next one begun; when all of them
/// together would grow beyond their bound, the oldest are removed. Only files of exactly
/// this name whose first line says that mlrd wrote them count and are ever removed.
pub struct Recorder {
    dir: PathBuf,
    file_bytes: u64,
    total_bytes: u64,
    current: Option<Recording>,
}

struct Recording {
    log: LogStream<Counted<BufWriter<File>>>,
    path: PathBuf,
}

/// What became of recordings, for people to know.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RecordingNotice {
    /// A new file was begun.
    Begun(PathBuf),
    /// An old file was removed to stay below the bound.
    Removed(PathBuf),
}

const PREFIX: &str = "walk-";
const SUFFIX: &str = ".csv";
/// The first line of a recording, around the version that wrote it. Whoever reads logs
/// skips it.
const MARK: (&str, &str) = ("# mlrd ", IN_BODY_AXES);
/// The first line is no longer than this, whatever the version.
const MARK_BYTES: u64 = 200;

impl Recorder {
    /// A recorder with these bounds; `None` when there is nowhere to record to.
    pub fn new(settings: &RecordSettings) -> Option<Self> {
        let bytes = |megabytes: f64| (megabytes * 1e6) as u64;
        Some(Self {
            dir: settings.dir.clone()?,
            file_bytes: bytes(settings.file_mb),
            total_bytes: bytes(settings.total_mb),
            current: None,
        })
    }

    /// Records a reading taken about `now`.
    ///
    /// # Errors
    /// When the directory or the file cannot be written.
    pub fn record(
        &mut self,
        now: SystemTime,
        reading: &Reading,
    ) -> io::Result<Vec<RecordingNotice>> {
        let mut notices = Vec::new();
        let mut recording = match self.current.take() {
            Some(recording) => recording,
            None => self.begin(now, &mut notices)?,
        };
        let attitude = reading.attitude;
        recording
            .log
            .write(attitude.time_s, &attitude.angles_rad, &reading.sample)?;
        if recording.log.get_ref().bytes < self.file_bytes {
            self.current = Some(recording);
        } else {
            recording.log.flush()?;
        }
        Ok(notices)
    }

    /// Brings to the file what is still in memory.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn flush(&mut self) -> io::Result<()> {
        self.current
            .as_mut()
            .map_or(Ok(()), |recording| recording.log.flush())
    }

    /// The file being written, if there is one.
    pub fn path(&self) -> Option<&Path> {
        self.current.as_ref().map(|recording| &*recording.path)
    }

    fn begin(&self, now: SystemTime, notices: &mut Vec<RecordingNotice>) -> io::Result<Recording> {
        fs::create_dir_all(&self.dir)?;
        self.make_room(notices)?;
        let path = self.dir.join(file_name(now));
        let file = File::create_new(&path)?;
        notices.push(RecordingNotice::Begun(path.clone()));
        let mut text = Counted::new(BufWriter::new(file));
        let (before, after) = MARK;
        writeln!(text, "{before}{}{after}", env!("CARGO_PKG_VERSION"))?;
        // A recording that power cuts short must be known as one.
        text.flush()?;
        Ok(Recording {
            log: LogStream::new(text),
            path,
        })
    }

    /// Removes the oldest recordings until there is room for one more.
    fn make_room(&self, notices: &mut Vec<RecordingNotice>) -> io::Result<()> {
        let mut recordings = Vec::new();
        for entry in fs::read_dir(&self.dir)? {
            let entry = entry?;
            let named = entry.file_name().to_str().is_some_and(is_file_name);
            if named && entry.file_type()?.is_file() && is_marked(&entry.path()) {
                recordings.push((entry.path(), entry.metadata()?.len()));
            }
        }
        recordings.sort();
        let mut total: u64 = recordings.iter().map(|(_, bytes)| bytes).sum();
        for (path, bytes) in recordings {
            if total + self.file_bytes <= self.total_bytes {
                break;
            }
            fs::remove_file(&path)?;
            total -= bytes;
            notices.push(RecordingNotice::Removed(path));
        }
        Ok(())
    }
}

/// The name of a recording that begins at this time. Names sort by time; a colon is no good
/// in file names elsewhere.
fn file_name(time: SystemTime) -> String {
    let time = humantime::format_rfc3339_millis(time).to_string();
    format!("{PREFIX}{}{SUFFIX}", time.replace(':', ""))
}

/// Whether this is the name of a recording, to the letter.
fn is_file_name(name: &str) -> bool {
    let time = name
        .strip_prefix(PREFIX)
        .and_then(|rest| rest.strip_suffix(SUFFIX))
        .and_then(|time| {
            let (date, clock) = time.split_once('T')?;
            let (hours, rest) = clock.split_at_checked(2)?;
            let (minutes, seconds) = rest.split_at_checked(2)?;
            humantime::parse_rfc3339(&format!("{date}T{hours}:{minutes}:{seconds}")).ok()
        });
    time.is_some_and(|time| file_name(time) == name)
}

/// Whether the first line says that mlrd wrote the file. One that cannot be read is
/// somebody else's.
fn is_marked(path: &Path) -> bool {
    let first_line = || -> io::Result<String> {
        let mut line = String::new();
        BufReader::new(File::open(path)?.take(MARK_BYTES)).read_line(&mut line)?;
        Ok(line)
    };
    let (before, after) = MARK;
    first_line().is_ok_and(|line| {
        line.starts_with(before)
            && line
                .strip_suffix('\n')
                .is_some_and(|line| line.ends_with(after))
    })
}

/// Counts the bytes on their way.
#[derive(Debug)]
struct Counted<W> {
    inner: W,
    bytes: u64,
}

impl<W> Counted<W> {
    fn new(inner: W) -> Self {
        Self { inner, bytes: 0 }
    }
}

impl<W: Write> Write for Counted<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.inner.write(bytes)?;
        self.bytes += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use mlr_filter::Axes;
    use mlr_imu::{Columns, ImuSample, read_log};

    use super::*;
    use crate::attitude::Attitude;

    fn reading(time_s: f64) -> Reading {
        Reading {
            attitude: Attitude {
                time_s,
                angles_rad: Axes {
                    roll: 0.1,
                    pitch: 0.2,
                    yaw: time_s,
                },
            },
            sample: ImuSample::default(),
        }
    }

    fn recorder(dir: &Path, file_mb: f64, total_mb: f64) -> Recorder {
        Recorder::new(&RecordSettings {
            dir: Some(dir.into()),
            file_mb,
            total_mb,
        })
        .unwrap()
    }

    #[test]
    fn the_newest_readings_are_kept_and_removals_are_told() {
        let folder = tempfile::tempdir().unwrap();
        let precious = folder.path().join("mine.csv");
        fs::write(&precious, vec![b'x'; 50_000]).unwrap();
        let mut recorder = recorder(folder.path(), 0.01, 0.035);
        let mut removed = Vec::new();
        for i in 0..3000_u32 {
            let now = SystemTime::UNIX_EPOCH + Duration::from_millis(u64::from(i));
            for notice in recorder.record(now, &reading(f64::from(i) * 1e-3)).unwrap() {
                if let RecordingNotice::Removed(path) = notice {
                    removed.push(path);
                }
            }
        }
        recorder.flush().unwrap();
        let last = read_log(recorder.path().unwrap(), &Columns::default())
            .unwrap()
            .orientation;
        assert_eq!(last.times_s().last(), Some(&2.999));
        let kept: u64 = fs::read_dir(folder.path())
            .unwrap()
            .map(|entry| entry.unwrap())
            .filter(|entry| entry.path() != precious)
            .map(|entry| entry.metadata().unwrap().len())
            .sum();
        // A row may end beyond a file's size.
        assert!((20_000..35_200).contains(&kept), "{kept}");
        assert!(!removed.is_empty() && !removed.contains(&precious));
        assert_eq!(fs::read(&precious).unwrap().len(), 50_000);
    }

    #[test]
    fn files_that_somebody_else_put_there_are_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let time = |millis| SystemTime::UNIX_EPOCH + Duration::from_millis(millis);
        // Old and large: they would be the first to go.
        let marked = format!(
            "# mlrd 0.0.9: recorded in the body's axes (mounting applied)\n{}",
            "x".repeat(50_000)
        );
        let unmarked = "y".repeat(50_000);
        let theirs = [
            ("walk-mine.csv".to_string(), &marked),
            ("walk-1970-01-01T000000Z.csv".to_string(), &marked),
            ("walk-1970-01-01T000000.000Z.csv.csv".to_string(), &marked),
            (file_name(time(0)), &unmarked),
            ("mine.csv".to_string(), &unmarked),
        ];
        for (name, text) in &theirs {
            fs::write(at(name), text).unwrap();
        }
        let ours = at(&file_name(time(1)));
        fs::write(&ours, &marked).unwrap();
        fs::create_dir(at(&file_name(time(2)))).unwrap();

        let mut recorder = recorder(folder.path(), 0.01, 0.02);
        let mut removed = Vec::new();
        for i in 0..1000_u32 {
            let notices = recorder.record(time(1000 + u64::from(i)), &reading(f64::from(i)));
            for notice in notices.unwrap() {
                if let RecordingNotice::Removed(path) = notice {
                    removed.push(path);
                }
            }
        }
        assert_eq!(removed[0], ours);
        assert!(removed.len() > 1, "full recordings go as well");
        for (name, text) in &theirs {
            assert_eq!(&fs::read_to_string(at(name)).unwrap(), *text, "{name}");
        }
    }

    #[test]
    fn a_recording_says_what_wrote_it() {
        let folder = tempfile::tempdir().unwrap();
        let mut recorder = recorder(folder.path(), 1.0, 2.0);
        recorder
            .record(SystemTime::UNIX_EPOCH, &reading(0.0))
            .unwrap();
        let path = recorder.path().unwrap().to_path_buf();
        assert!(path.ends_with("walk-1970-01-01T000000.000Z.csv"));
        assert!(is_file_name(path.file_name().unwrap().to_str().unwrap()));
        assert!(is_marked(&path), "before the first flush, too");
        recorder.flush().unwrap();
        let text = fs::read_to_string(&path).unwrap();
        let expected = format!(
            "# mlrd {}: recorded in the body's axes (mounting applied)",
            env!("CARGO_PKG_VERSION")
        );
        assert_eq!(text.lines().next(), Some(&*expected));
    }

    #[test]
    fn a_directory_that_cannot_be_written_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        let mut recorder = recorder(&file, 1.0, 2.0);
        assert!(
            recorder
                .record(SystemTime::UNIX_EPOCH, &reading(0.0))
                .is_err()
        );
    }
}
