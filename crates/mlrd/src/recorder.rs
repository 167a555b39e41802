//! Records what the sensor says, bounded in size.

use std::{
    fs::{self, File},
    io::{self, BufRead, BufReader, BufWriter, Read, Write},
    path::{Path, PathBuf},
    time::{SystemTime, UNIX_EPOCH},
};

use mlr_imu::{IN_BODY_AXES, LogStream, McapBegin, McapStream, mcap_library};

use crate::{
    sensor::Reading,
    settings::{RecordFormat, RecordSettings},
};

/// Writes readings to files, `walk-TIME.csv` or `.mcap`, that `mlr-ga` reads.
///
/// A file that is full is closed and the next one begun; when all of them
/// together would grow beyond their bound, the oldest are removed. Only files of exactly
/// this name that say at their beginning that mlrd wrote them count and are ever removed.
pub struct Recorder {
    dir: PathBuf,
    format: RecordFormat,
    file_bytes: u64,
    total_bytes: u64,
    current: Option<Recording>,
}

struct Recording {
    log: Log,
    path: PathBuf,
}

enum Log {
    Csv(LogStream<Counted<BufWriter<File>>>),
    Mcap(Box<McapStream<BufWriter<File>>>),
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
const SUFFIXES: [&str; 2] = [".csv", ".mcap"];
/// What wrote a recording, before the version.
const WRITER: &str = "mlrd ";
/// The first line of a table, around the version that wrote it. Whoever reads logs
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
            format: settings.format,
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
            None => self.begin(now, reading.attitude.time_s, &mut notices)?,
        };
        recording.log.write(reading)?;
        if recording.log.bytes() < self.file_bytes {
            self.current = Some(recording);
        } else {
            recording.log.finish()?;
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

    /// Begins a file at a time of the clock on the wall and of the log.
    fn begin(
        &self,
        now: SystemTime,
        time_s: f64,
        notices: &mut Vec<RecordingNotice>,
    ) -> io::Result<Recording> {
        fs::create_dir_all(&self.dir)?;
        self.make_room(notices)?;
        let path = self.dir.join(file_name(now, self.format));
        let file = BufWriter::new(File::create_new(&path)?);
        notices.push(RecordingNotice::Begun(path.clone()));
        let mut log = match self.format {
            RecordFormat::Csv => {
                let mut text = Counted::new(file);
                let (before, after) = MARK;
                writeln!(text, "{before}{}{after}", env!("CARGO_PKG_VERSION"))?;
                Log::Csv(LogStream::new(text))
            }
            RecordFormat::Mcap => {
                let since_1970 = now.duration_since(UNIX_EPOCH).unwrap_or_default();
                let now_ns = i64::try_from(since_1970.as_nanos()).unwrap_or_default();
                let begin = McapBegin {
                    library: &format!("{WRITER}{}", env!("CARGO_PKG_VERSION")),
                    begin_ns: now_ns.saturating_sub((time_s * 1e9) as i64),
                    in_body_axes: true,
                    has_orientations: true,
                    // What power cuts short has no index, and nothing else is missing.
                    chunked: false,
                };
                Log::Mcap(Box::new(McapStream::new(file, &begin)?))
            }
        };
        // A recording that power cuts short must be known as one.
        log.flush()?;
        Ok(Recording { log, path })
    }

    /// Removes the oldest recordings until there is room for one more.
    fn make_room(&self, notices: &mut Vec<RecordingNotice>) -> io::Result<()> {
        let recordings = recordings(&self.dir)?;
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

/// The recordings in a directory, oldest first, and how large each is.
///
/// # Errors
/// When the directory cannot be read.
pub(crate) fn recordings(dir: &Path) -> io::Result<Vec<(PathBuf, u64)>> {
    let mut recordings = Vec::new();
    for entry in fs::read_dir(dir)? {
        let entry = entry?;
        let named = entry.file_name().to_str().is_some_and(is_file_name);
        if named && entry.file_type()?.is_file() && is_marked(&entry.path()) {
            recordings.push((entry.path(), entry.metadata()?.len()));
        }
    }
    recordings.sort();
    Ok(recordings)
}

impl Drop for Recording {
    fn drop(&mut self) {
        // Without its end a recording is read as well.
        let _ = self.log.finish();
    }
}

impl Log {
    fn write(&mut self, reading: &Reading) -> io::Result<()> {
        let (attitude, sample) = (&reading.attitude, &reading.sample);
        let angles_rad = &attitude.angles_rad;
        match self {
            Self::Csv(log) => log.write(attitude.time_s, angles_rad, sample),
            Self::Mcap(log) => log.write(attitude.time_s, Some(angles_rad), sample),
        }
    }

    fn bytes(&self) -> u64 {
        match self {
            Self::Csv(log) => log.get_ref().bytes,
            Self::Mcap(log) => log.bytes(),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Csv(log) => log.flush(),
            Self::Mcap(log) => log.flush(),
        }
    }

    /// Writes the end of the file.
    fn finish(&mut self) -> io::Result<()> {
        match self {
            Self::Csv(log) => log.flush(),
            Self::Mcap(log) => log.finish(),
        }
    }
}

/// The name of a recording that begins at this time. Names sort by time; a colon is no good
/// in file names elsewhere.
fn file_name(time: SystemTime, format: RecordFormat) -> String {
    let time = humantime::format_rfc3339_millis(time).to_string();
    let [csv, mcap] = SUFFIXES;
    let suffix = match format {
        RecordFormat::Csv => csv,
        RecordFormat::Mcap => mcap,
    };
    format!("{PREFIX}{}{suffix}", time.replace(':', ""))
}

/// Whether this is the name of a recording, to the letter.
fn is_file_name(name: &str) -> bool {
    let formats = [RecordFormat::Csv, RecordFormat::Mcap];
    formats.into_iter().zip(SUFFIXES).any(|(format, suffix)| {
        let time = name
            .strip_prefix(PREFIX)
            .and_then(|rest| rest.strip_suffix(suffix))
            .and_then(|time| {
                let (date, clock) = time.split_once('T')?;
                let (hours, rest) = clock.split_at_checked(2)?;
                let (minutes, seconds) = rest.split_at_checked(2)?;
                humantime::parse_rfc3339(&format!("{date}T{hours}:{minutes}:{seconds}")).ok()
            });
        time.is_some_and(|time| file_name(time, format) == name)
    })
}

/// Whether the beginning of a file says that mlrd wrote it. One that cannot be read is
/// somebody else's.
fn is_marked(path: &Path) -> bool {
    let first_line = || -> io::Result<String> {
        let mut line = String::new();
        BufReader::new(File::open(path)?.take(MARK_BYTES)).read_line(&mut line)?;
        Ok(line)
    };
    let (before, after) = MARK;
    let is_our_table = first_line().is_ok_and(|line| {
        line.starts_with(before)
            && line
                .strip_suffix('\n')
                .is_some_and(|line| line.ends_with(after))
    });
    let library = || File::open(path).ok().and_then(mcap_library);
    is_our_table || library().is_some_and(|library| library.starts_with(WRITER))
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
            format: RecordFormat::Csv,
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
            (file_name(time(0), RecordFormat::Csv), &unmarked),
            ("mine.csv".to_string(), &unmarked),
        ];
        for (name, text) in &theirs {
            fs::write(at(name), text).unwrap();
        }
        let ours = at(&file_name(time(1), RecordFormat::Csv));
        fs::write(&ours, &marked).unwrap();
        fs::create_dir(at(&file_name(time(2), RecordFormat::Csv))).unwrap();

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
    fn a_recording_as_mcap_outlives_a_power_cut() {
        let folder = tempfile::tempdir().unwrap();
        let mut recorder = Recorder::new(&RecordSettings {
            dir: Some(folder.path().into()),
            format: RecordFormat::Mcap,
            file_mb: 0.1,
            total_mb: 0.25,
        })
        .unwrap();
        let begin = SystemTime::UNIX_EPOCH + Duration::from_secs(1_700_000_000);
        let (mut begun, mut removed) = (Vec::new(), Vec::new());
        for i in 0..1000_u32 {
            let reading = reading(5.0 + f64::from(i) * 1e-3);
            let now = begin + Duration::from_millis(i.into());
            for notice in recorder.record(now, &reading).unwrap() {
                match notice {
                    RecordingNotice::Begun(path) => begun.push(path),
                    RecordingNotice::Removed(path) => removed.push(path),
                }
            }
        }
        assert!(begun.len() > 2 && !removed.is_empty());
        assert_eq!(removed[0], begun[0]);
        assert!(begun[0].ends_with("walk-2023-11-14T221320.000Z.mcap"));
        // One that is full has its end.
        let full = read_log(&begun[begun.len() - 2], &Columns::default()).unwrap();
        assert!(
            full.in_body_axes && full.notes.is_empty(),
            "{:?}",
            full.notes
        );

        recorder.flush().unwrap();
        let whole = fs::read(recorder.path().unwrap()).unwrap();
        let cut = folder.path().join("cut.mcap");
        fs::write(&cut, &whole[..whole.len() - 100]).unwrap();
        let rows = |path: &Path| {
            let recording = read_log(path, &Columns::default()).unwrap();
            assert!(
                recording.notes[0].contains("missing") || recording.notes[0].contains("cut off")
            );
            recording.orientation.len()
        };
        assert_eq!(rows(&cut) + 1, rows(recorder.path().unwrap()));
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
