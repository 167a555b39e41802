//! The daemon whose output nobody reads, on a real pseudo-terminal. Time is the device's, as
//! fast as the daemon reads.

use std::{
    fs,
    io::{BufRead, BufReader, PipeReader, PipeWriter, Write, pipe},
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use crate::daemon::{
    Daemon, HANG,
    player::{Device, Line},
    signal,
};
use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
use tempfile::TempDir;

/// A second, for a computer that has sixty other things to do.
const ENDS_WITHIN: Duration = Duration::from_secs(60);

/// A daemon that records, and the line that it listens to.
struct Recording {
    child: Child,
    line: Option<Line>,
    port: PathBuf,
    folder: TempDir,
}

impl Drop for Recording {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Recording {
    fn start(stdout: impl Into<Stdio>, stderr: impl Into<Stdio>) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let config = folder.path().join("mlrd.toml");
        fs::write(&config, "status_every_s = 0.1\n").unwrap();
        let port = folder.path().join("imu");
        let child = Command::new(env!("CARGO_BIN_EXE_mlrd"))
            .args(["--config".as_ref(), config.as_os_str()])
            .args(["--port".as_ref(), port.as_os_str()])
            .args([
                "--record".as_ref(),
                folder.path().join("recordings").as_os_str(),
            ])
            .stdout(stdout)
            .stderr(stderr)
            .spawn()
            .unwrap();
        Self {
            child,
            line: None,
            port,
            folder,
        }
    }

    /// Plays so much of a walk, and waits until it is recorded without a gap.
    fn plays(&mut self, duration_s: f64) {
        let line = self.line.insert(Line::plugged_in(&self.port));
        let frames = Device::RegisterBurst.frames_at_1_khz("healthy.csv.gz", duration_s + 20.0);
        // Nothing tells when the port is open: the first seconds are played until something
        // is recorded.
        let (mut sent, end) = (0, Instant::now() + HANG);
        while recording(self.folder.path()).is_none() {
            assert!(Instant::now() < end, "nothing is recorded");
            if sent < 20_000 && is_open(self.child.id(), &self.port) {
                line.send_all(&frames[sent..sent + 100]);
                sent += 100;
            }
            thread::sleep(Duration::from_millis(5));
        }
        let count = (duration_s * 1000.0) as usize;
        line.send_all(&frames[sent..sent + count]);
        let path = recording(self.folder.path()).unwrap();
        // The last sample is held back by the filter of spikes.
        while rows(&path) < count - 1 {
            assert!(Instant::now() < end, "{} rows of {count}", rows(&path));
            thread::sleep(Duration::from_millis(200));
        }
    }

    /// Ends it by a signal: one that waits for its reader never would.
    fn ends_by(mut self, name: &str) -> Vec<f64> {
        signal(self.child.id(), name);
        let signalled = Instant::now();
        let status = loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                break status;
            }
            assert!(signalled.elapsed() < ENDS_WITHIN, "it runs on");
            thread::sleep(Duration::from_millis(5));
        };
        assert_eq!(status.code(), Some(0));
        let path = recording(self.folder.path()).unwrap();
        let log = mlr_imu::read_log(&path, &mlr_imu::Columns::default()).unwrap();
        log.orientation.times_s().to_vec()
    }
}

/// The file that is being recorded.
fn recording(folder: &Path) -> Option<PathBuf> {
    let entry = fs::read_dir(folder.join("recordings")).ok()?.next()?;
    Some(entry.unwrap().path())
}

fn rows(path: &Path) -> usize {
    BufReader::new(fs::File::open(path).unwrap())
        .lines()
        .count()
        .saturating_sub(2)
}

/// Whether the process has opened the port.
fn is_open(process: u32, port: &Path) -> bool {
    let terminal = fs::read_link(port).unwrap();
    fs::read_dir(format!("/proc/{process}/fd"))
        .unwrap()
        .filter_map(|descriptor| fs::read_link(descriptor.ok()?.path()).ok())
        .any(|open| open == terminal)
}

/// A pipe that takes nothing more until it is read.
fn full_pipe() -> (PipeReader, PipeWriter) {
    let (reader, mut writer) = pipe().unwrap();
    let flags = fcntl_getfl(&writer).unwrap();
    fcntl_setfl(&writer, flags | OFlags::NONBLOCK).unwrap();
    while writer.write(&[b'\n'; 4096]).is_ok() {}
    fcntl_setfl(&writer, flags).unwrap();
    (reader, writer)
}

fn assert_no_gaps(times_s: &[f64], duration_s: f64) {
    let last_s = times_s.last().unwrap();
    let since = times_s.partition_point(|time_s| last_s - time_s > duration_s - 0.01);
    let longest_s = times_s[since..]
        .windows(2)
        .map(|two| two[1] - two[0])
        .fold(0.0, f64::max);
    assert!(longest_s < 1.5e-3, "a gap of {longest_s} s");
    assert!(times_s.len() as f64 > duration_s * 1000.0 - 2.0);
}

#[test]
fn a_reader_that_never_reads_delays_neither_reading_nor_sigterm() {
    let (_stdout, to_stdout) = full_pipe();
    let (_stderr, to_stderr) = full_pipe();
    let mut recording = Recording::start(to_stdout, to_stderr);
    recording.plays(60.0);
    assert_no_gaps(&recording.ends_by("TERM"), 60.0);
}

#[test]
fn sighup_and_sigint_end_it_as_well() {
    for name in ["HUP", "INT"] {
        let (_stdout, to_stdout) = full_pipe();
        let (_stderr, to_stderr) = full_pipe();
        let mut recording = Recording::start(to_stdout, to_stderr);
        recording.plays(2.0);
        assert_no_gaps(&recording.ends_by(name), 2.0);
    }
}

#[test]
fn a_closed_stdout_is_told_once_and_recording_goes_on() {
    let (stdout, to_stdout) = pipe().unwrap();
    drop(stdout);
    let (stderr, to_stderr) = pipe().unwrap();
    let mut recording = Recording::start(to_stdout, to_stderr);
    recording.plays(5.0);
    assert_no_gaps(&recording.ends_by("TERM"), 5.0);
    let messages: Vec<String> = BufReader::new(stderr).lines().map(Result::unwrap).collect();
    assert_eq!(
        messages,
        ["mlrd: stdout was closed: events are discarded from now on"]
    );
}

#[test]
fn a_reader_that_comes_back_gets_all_but_the_oldest_status() {
    let (stdout, to_stdout) = full_pipe();
    let mut recording = Recording::start(to_stdout, Stdio::null());
    recording.plays(2.0);
    // 64 status wait. Another daemon, which is read, shows when there were more.
    let config = recording.folder.path().join("mlrd.toml");
    let beside = ["--port".as_ref(), "/dev/none-such".as_ref()];
    let other = Daemon::start(
        beside
            .into_iter()
            .chain(["--config".as_ref(), config.as_os_str()]),
    );
    for _ in 0..100 {
        other.next("status");
    }
    other.terminate();
    let mut told = BufReader::new(stdout)
        .lines()
        .map(Result::unwrap)
        .filter(|line| !line.is_empty())
        .map(|line| serde_json::from_str::<serde_json::Value>(&line).unwrap());
    let mut names = Vec::new();
    let status = loop {
        let event = told.next().unwrap();
        let name = event["event"].as_str().unwrap().to_string();
        if name == "status" && event["dropped_status"] != 0 {
            break event;
        }
        names.push(name);
        assert!(names.len() < 200, "nothing was dropped");
    };
    assert!(status["dropped_status"].as_u64().unwrap() > 5, "{status}");
    assert_eq!(status["dropped_events"], 0);
    for kept in ["started", "port_opened", "recording_begun"] {
        assert!(names.iter().any(|name| name == kept), "{kept} of {names:?}");
    }
    signal(recording.child.id(), "TERM");
    let last = told.last().unwrap();
    assert_eq!(last["event"], "stopped");
}
