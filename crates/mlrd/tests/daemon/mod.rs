//! A running daemon, and what a test wants of it.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    dead_code,
    reason = "a test that cannot go on has failed, what it measured is shown, and not every test uses all of it"
)]

pub(crate) mod player;

use std::{
    ffi::OsStr,
    io::{BufRead, BufReader},
    path::Path,
    process::{Child, Command, Stdio},
    sync::mpsc::{self, Receiver},
    thread,
    time::{Duration, Instant},
};

use serde_json::Value;

pub(crate) struct Daemon {
    child: Child,
    events: Receiver<Value>,
}

impl Daemon {
    pub(crate) fn start<S: AsRef<OsStr>>(arguments: impl IntoIterator<Item = S>) -> Self {
        Self::spawn(Command::new(env!("CARGO_BIN_EXE_mlrd")).args(arguments))
    }

    pub(crate) fn spawn(command: &mut Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        let (send, events) = mpsc::channel();
        let stdout = BufReader::new(child.stdout.take().unwrap());
        thread::spawn(move || {
            for line in stdout.lines() {
                let event: Value = serde_json::from_str(&line.unwrap()).unwrap();
                if send.send(event).is_err() {
                    return;
                }
            }
        });
        Self { child, events }
    }

    pub(crate) fn id(&self) -> u32 {
        self.child.id()
    }

    /// Waits for the next event of this name; others are passed over.
    pub(crate) fn next(&self, wanted: &str) -> Value {
        self.next_within(wanted, PATIENCE)
    }

    /// Everything that is told up to the first event of this kind that is as wanted.
    pub(crate) fn told_until(&self, is_wanted: impl Fn(&Value) -> bool) -> Vec<Value> {
        let end = Instant::now() + PATIENCE;
        let mut told = Vec::new();
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let Ok(event) = self.events.recv_timeout(left) else {
                panic!("not within {PATIENCE:?}, only {told:#?}");
            };
            told.push(event);
            if told.last().is_some_and(&is_wanted) {
                return told;
            }
        }
    }

    pub(crate) fn next_within(&self, wanted: &str, patience: Duration) -> Value {
        let end = Instant::now() + patience;
        let mut passed = Vec::new();
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let Ok(event) = self.events.recv_timeout(left) else {
                panic!("no {wanted:?} within {patience:?}, only {passed:?}");
            };
            if event["event"] == wanted {
                return event;
            }
            passed.push(event["event"].clone());
        }
    }

    /// Ends it as a service manager does; it must end well.
    pub(crate) fn terminate(mut self) {
        signal(self.child.id(), "TERM");
        self.next("stopped");
        assert!(self.child.wait().unwrap().success());
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Sends a signal, by its name without SIG.
pub(crate) fn signal(process: u32, name: &str) {
    let mut kill = Command::new("kill");
    let killed = kill.args([&format!("-{name}"), &process.to_string()]);
    assert!(killed.status().unwrap().success());
}

/// How long a daemon on a busy computer may take for anything.
pub(crate) const PATIENCE: Duration = Duration::from_secs(600);

/// The log whose robot stands for 6 s, walks, and loses legs 3 and 4 at 19 s.
pub(crate) const LOG: &str = "detect-legs3-4.csv.gz";
const START_S: f64 = 6.0;
const DAMAGE_S: f64 = 19.0;

/// What the daemon must say about [`LOG`].
pub(crate) fn expect_legs_3_and_4(daemon: &Daemon, patience: Duration) {
    let started = daemon.next_within("motion_started", patience);
    let start_s = started["motion_start_s"].as_f64().unwrap();
    assert!((start_s - START_S).abs() < 0.15, "{start_s}");
    let damage = daemon.next_within("damage_detected", patience);
    let delay_s = damage["t_s"].as_f64().unwrap() - DAMAGE_S;
    assert!((2.0..3.5).contains(&delay_s), "{delay_s}");
    let identified = daemon.next_within("identified", patience);
    let legs = &identified["result"]["damaged_legs"];
    assert_eq!(legs, &serde_json::json!([3, 4]));
    assert_eq!(identified["level"], 2);
    println!(
        "motion {start_s:.2} s, damage flagged {delay_s:.2} s after it struck, identified: {} in {:.1} s",
        identified["result"]["description"].as_str().unwrap(),
        identified["result"]["elapsed_s"].as_f64().unwrap(),
    );
}

/// Makes `link` the name of `target`, as udev does when a device is plugged in.
pub(crate) fn plug_in(link: &Path, target: &str) {
    let _ = std::fs::remove_file(link);
    std::os::unix::fs::symlink(target, link).unwrap();
}

/// The fields of a `stat` of proc(5) from the third on: those before it are the number and
/// the name, which may hold blanks.
pub(crate) fn stat_fields(stat: &str) -> Vec<&str> {
    stat.rsplit(')')
        .next()
        .unwrap()
        .split_whitespace()
        .collect()
}
