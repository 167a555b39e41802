//! A file of finished results, so that a run that was interrupted goes on where it was.
//!
//! JSON lines: the first says which program made the results with what settings, each other one
//! is the result of a log.

use std::{
    fs::{File, OpenOptions},
    io::{self, Read, Seek, SeekFrom, Write},
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
};

use anyhow::{Context, bail};
use crc::{CRC_64_XZ, Crc};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use serde_json::Value;

use mlr_imu::read_text;

use super::output;

/// Version of the file.
const SCHEMA: &str = "mlr.resume/1";
/// The most that is read of it: some ten thousand logs.
const MAX_BYTES: u64 = 1_000_000_000;
const CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_XZ);

/// What makes results comparable. The first line of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct RunIdentity {
    schema: String,
    /// Version of the program, and check sum of its file: builds of one version differ.
    program: String,
    /// Everything that results depend on beside the logs.
    settings: Value,
}

impl RunIdentity {
    /// This program with these settings.
    pub(super) fn new(settings: Value) -> Self {
        Self {
            schema: SCHEMA.into(),
            program: this_build(),
            settings,
        }
    }

    /// Refuses results of another program or of other settings.
    fn check(&self, recorded: &Self) -> anyhow::Result<()> {
        let advice = "expected another file, or none of this name, to begin anew";
        for (what, recorded, own) in [
            ("format", &recorded.schema, &self.schema),
            ("program", &recorded.program, &self.program),
        ] {
            if recorded != own {
                bail!("results of another {what} ({recorded}; this one: {own}): {advice}");
            }
        }
        // As it is read from a file: numbers may change in their last digit.
        let own: Self = serde_json::from_str(&serde_json::to_string(self)?)?;
        if let Some(difference) = first_difference(&own.settings, &recorded.settings) {
            let Difference {
                name,
                own,
                recorded,
            } = difference;
            bail!("results of another setting ({name}: {recorded}; this one: {own}): {advice}");
        }
        Ok(())
    }
}

/// A setting that differs.
struct Difference<'a> {
    /// Its name, after those that it is under.
    name: String,
    own: &'a Value,
    recorded: &'a Value,
}

fn first_difference<'a>(own: &'a Value, recorded: &'a Value) -> Option<Difference<'a>> {
    if own == recorded {
        return None;
    }
    let (Value::Object(own_ones), Value::Object(recorded_ones)) = (own, recorded) else {
        return Some(Difference {
            name: String::new(),
            own,
            recorded,
        });
    };
    own_ones
        .keys()
        .chain(recorded_ones.keys())
        .find_map(|name| {
            let value =
                |of: &'a serde_json::Map<String, Value>| of.get(name).unwrap_or(&Value::Null);
            let inner = first_difference(value(own_ones), value(recorded_ones))?;
            let name = match inner.name.as_str() {
                "" => name.clone(),
                rest => format!("{name}.{rest}"),
            };
            Some(Difference { name, ..inner })
        })
}

/// Version of the program, and check sum of its file.
pub(super) fn this_build() -> String {
    let build = std::env::current_exe()
        .and_then(|path| checksum_of_file(&path))
        .unwrap_or_else(|_| "unknown".into());
    format!("{}, build {build}", env!("CARGO_PKG_VERSION"))
}

/// Check sum of a file, as text.
pub(super) fn checksum_of_file(path: &Path) -> io::Result<String> {
    let mut file = File::open(path)?;
    let mut digest = CRC.digest();
    let mut block = vec![0; 1 << 16];
    loop {
        match file.read(&mut block)? {
            0 => return Ok(format!("{:016x}", digest.finalize())),
            read => digest.update(&block[..read]),
        }
    }
}

/// Check sum of a text.
pub(super) fn checksum(text: &str) -> String {
    format!("{:016x}", CRC.checksum(text.as_bytes()))
}

/// Which log a result is of.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct LogIdentity {
    /// Directory of the log.
    pub(super) directory: PathBuf,
    /// Its name.
    pub(super) log: String,
    /// Check sum of the log and of what is known about it.
    pub(super) checksum: String,
}

#[derive(Serialize, Deserialize)]
struct Line<R> {
    #[serde(flatten)]
    of: LogIdentity,
    result: R,
}

/// Results that files hold.
#[derive(Debug)]
pub(super) struct Finished<R> {
    paths: Vec<PathBuf>,
    results: Vec<(LogIdentity, R)>,
}

/// The file, with the results that were in it at the beginning.
#[derive(Debug)]
pub(super) struct ResumeFile<R> {
    path: PathBuf,
    file: Mutex<File>,
    finished: Finished<R>,
}

impl<R: Serialize + DeserializeOwned> ResumeFile<R> {
    /// Opens the file, or makes a new one. A last line that was not written to its end is
    /// dropped.
    ///
    /// # Errors
    /// When the file cannot be read and written, holds something else, or results of another
    /// program or of other settings.
    pub(super) fn open(path: &Path, run: &RunIdentity) -> anyhow::Result<Self> {
        output::refuse_stdout(path)?;
        let name = || path.display().to_string();
        let mut text = String::new();
        let mut file = OpenOptions::new()
            .read(true)
            .append(true)
            .create(true)
            .open(path)
            .with_context(name)?;
        let size = file.metadata().with_context(name)?.len();
        if size > MAX_BYTES {
            bail!("{}: {size} bytes, expected at most {MAX_BYTES}", name());
        }
        file.read_to_string(&mut text).with_context(name)?;
        if text.is_empty() {
            let line = serde_json::to_string(run)? + "\n";
            file.write_all(line.as_bytes()).with_context(name)?;
        }
        let results = results_in(&text, run).with_context(name)?;
        // Only now that the file is known to be one of results.
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        if whole < text.len() {
            file.set_len(whole as u64).with_context(name)?;
            file.seek(SeekFrom::End(0)).with_context(name)?;
            output::warning(&format!(
                "{}: the last line was cut off: that log is run again",
                name()
            ));
        }
        Ok(Self {
            path: path.into(),
            file: Mutex::new(file),
            finished: Finished {
                paths: vec![path.into()],
                results,
            },
        })
    }

    /// What was in it at the beginning.
    pub(super) fn finished(&self) -> &Finished<R> {
        &self.finished
    }

    /// The result of a log, as [`Finished::result`].
    #[cfg(test)]
    fn result(&self, of: &LogIdentity) -> anyhow::Result<Option<&R>> {
        self.finished.result(of)
    }

    /// Adds a result; it is in the file when this returns.
    pub(super) fn append(&self, of: &LogIdentity, result: &R) -> anyhow::Result<()> {
        let line = serde_json::to_string(&Line {
            of: of.clone(),
            result,
        })? + "\n";
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.write_all(line.as_bytes())
            .and_then(|()| file.sync_data())
            .with_context(|| self.path.display().to_string())
    }
}

fn results_in<R: DeserializeOwned>(
    text: &str,
    run: &RunIdentity,
) -> anyhow::Result<Vec<(LogIdentity, R)>> {
    if text.is_empty() {
        return Ok(Vec::new());
    }
    let mut lines = text.split_inclusive('\n').enumerate();
    let first = lines.next().map_or("", |(_, line)| line);
    let recorded: RunIdentity = serde_json::from_str(first)
        .context("line 1: expected results of an earlier run, or no file of this name")?;
    if !first.ends_with('\n') {
        bail!("line 1: cut off, expected no file of this name, to begin anew");
    }
    run.check(&recorded).context("line 1")?;
    lines
        .filter(|(_, line)| line.ends_with('\n'))
        .map(|(index, line)| {
            let line: Line<R> = serde_json::from_str(line).with_context(|| {
                format!(
                    "line {}: expected the result of a log; without this line, it is run again",
                    index + 1
                )
            })?;
            Ok((line.of, line.result))
        })
        .collect()
}

impl<R: DeserializeOwned> Finished<R> {
    /// Reads the results of several files.
    ///
    /// # Errors
    /// When one cannot be read, holds something else, or results of another program or of other
    /// settings, and when two have the same log.
    pub(super) fn read(paths: &[PathBuf], run: &RunIdentity) -> anyhow::Result<Self> {
        let mut results: Vec<(LogIdentity, R)> = Vec::new();
        for path in paths {
            let name = || path.display().to_string();
            let text = read_text(path, MAX_BYTES).with_context(name)?;
            if text.is_empty() {
                bail!("{}: is empty, expected results", name());
            }
            for (of, result) in results_in::<R>(&text, run).with_context(name)? {
                if results
                    .iter()
                    .any(|(known, _)| known.log == of.log && known.checksum == of.checksum)
                {
                    bail!(
                        "{}: {} has a result already, expected each part once",
                        name(),
                        of.directory.join(&of.log).display()
                    );
                }
                results.push((of, result));
            }
        }
        Ok(Self {
            paths: paths.to_vec(),
            results,
        })
    }

    /// The result of a log, if it is there. The directory may be named otherwise than before.
    ///
    /// # Errors
    /// When there is one of a log of this name in this directory that has changed since.
    pub(super) fn result(&self, of: &LogIdentity) -> anyhow::Result<Option<&R>> {
        let is_same = |known: &LogIdentity| known.log == of.log && known.checksum == of.checksum;
        if let Some((_, result)) = self.results.iter().find(|(known, _)| is_same(known)) {
            return Ok(Some(result));
        }
        let is_at = |known: &LogIdentity| known.log == of.log && known.directory == of.directory;
        if self.results.iter().any(|(known, _)| is_at(known)) {
            bail!(
                "{}: {}: the log or its truth has changed since, expected another file, or none of \
                 this name, to begin anew",
                self.names(),
                of.directory.join(&of.log).display()
            );
        }
        Ok(None)
    }

    fn names(&self) -> String {
        let names = self.paths.iter().map(|path| path.display().to_string());
        names.collect::<Vec<_>>().join(", ")
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use serde_json::json;

    use super::*;

    fn run(settings: Value) -> RunIdentity {
        RunIdentity {
            schema: SCHEMA.into(),
            program: "1.0.0, build 1".into(),
            settings,
        }
    }

    fn log(name: &str, checksum: &str) -> LogIdentity {
        LogIdentity {
            directory: "logs".into(),
            log: name.into(),
            checksum: checksum.into(),
        }
    }

    fn open(path: &Path, seed: u64) -> anyhow::Result<ResumeFile<f64>> {
        ResumeFile::open(path, &run(json!({"seed": seed, "effort": {"fits": 3}})))
    }

    #[test]
    fn finished_logs_are_known_to_the_next_run() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results.jsonl");
        let first = open(&path, 1).unwrap();
        assert_eq!(first.result(&log("a", "1")).unwrap(), None);
        first.append(&log("a", "1"), &0.5).unwrap();
        drop(first);
        let second = open(&path, 1).unwrap();
        assert_eq!(second.result(&log("a", "1")).unwrap(), Some(&0.5));
        assert_eq!(second.result(&log("b", "1")).unwrap(), None);
        second.append(&log("b", "2"), &0.25).unwrap();
        let third = open(&path, 1).unwrap();
        assert_eq!(third.result(&log("a", "1")).unwrap(), Some(&0.5));
        assert_eq!(third.result(&log("b", "2")).unwrap(), Some(&0.25));
        // The same log under another name of its directory.
        let elsewhere = LogIdentity {
            directory: "./logs".into(),
            ..log("b", "2")
        };
        assert_eq!(third.result(&elsewhere).unwrap(), Some(&0.25));
    }

    #[test]
    fn a_log_that_changed_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results.jsonl");
        open(&path, 1)
            .unwrap()
            .append(&log("a", "1"), &0.5)
            .unwrap();
        let file = open(&path, 1).unwrap();
        let error = file.result(&log("a", "2")).unwrap_err().to_string();
        assert!(
            error.contains("logs/a: the log or its truth has changed"),
            "{error}"
        );
        // A log of that name elsewhere is another one.
        let elsewhere = LogIdentity {
            directory: "others".into(),
            ..log("a", "2")
        };
        assert_eq!(file.result(&elsewhere).unwrap(), None);
    }

    #[test]
    fn results_of_other_settings_or_programs_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results.jsonl");
        open(&path, 1).unwrap();
        let error = format!("{:#}", open(&path, 2).unwrap_err());
        assert!(error.contains("results.jsonl: line 1"), "{error}");
        assert!(error.contains("(seed: 1; this one: 2)"), "{error}");
        let other_effort = run(json!({"seed": 1, "effort": {"fits": 4}}));
        let error = ResumeFile::<f64>::open(&path, &other_effort).unwrap_err();
        assert!(
            format!("{error:#}").contains("(effort.fits: 3; this one: 4)"),
            "{error:#}"
        );
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, text.replace("build 1", "build 2")).unwrap();
        let error = format!("{:#}", open(&path, 1).unwrap_err());
        assert!(error.contains("another program (1.0.0, build 2"), "{error}");
    }

    #[test]
    fn a_line_that_was_cut_off_is_run_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results.jsonl");
        let file = open(&path, 1).unwrap();
        file.append(&log("a", "1"), &0.5).unwrap();
        let whole = fs::read_to_string(&path).unwrap();
        file.append(&log("b", "1"), &0.25).unwrap();
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, &text[..text.len() - 7]).unwrap();
        let file = open(&path, 1).unwrap();
        assert_eq!(file.result(&log("a", "1")).unwrap(), Some(&0.5));
        assert_eq!(file.result(&log("b", "1")).unwrap(), None);
        assert_eq!(fs::read_to_string(&path).unwrap(), whole);
        file.append(&log("b", "1"), &0.25).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), text);
    }

    #[test]
    fn other_files_stay_as_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("notes.txt");
        for text in ["notes", "notes\nmore", "{}\n", "\n"] {
            fs::write(&path, text).unwrap();
            let error = format!("{:#}", open(&path, 1).unwrap_err());
            assert!(error.contains("notes.txt: line 1"), "{error}");
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
        let own = serde_json::to_string(&run(json!({"seed": 1, "effort": {"fits": 3}}))).unwrap();
        fs::write(&path, format!("{own}\nnotes\n")).unwrap();
        let error = format!("{:#}", open(&path, 1).unwrap_err());
        assert!(
            error.contains("line 2: expected the result of a log"),
            "{error}"
        );
    }
}
