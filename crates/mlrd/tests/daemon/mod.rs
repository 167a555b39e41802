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
    sync::mpsc::{self, Receiver, RecvTimeoutError},
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
        let told = self.told_until(|event| event["event"] == wanted);
        told.into_iter().next_back().unwrap()
    }

    /// Everything that is told up to the first event that is as wanted. It is waited for as
    /// long as the daemon lives, however slow the computer is.
    pub(crate) fn told_until(&self, is_wanted: impl Fn(&Value) -> bool) -> Vec<Value> {
        let hang = Instant::now() + HANG;
        let mut told = Vec::new();
        loop {
            let left = hang.saturating_duration_since(Instant::now());
            match self.events.recv_timeout(left) {
                Ok(event) => told.push(event),
                Err(RecvTimeoutError::Disconnected) => panic!("it ended after {told:#?}"),
                Err(RecvTimeoutError::Timeout) => panic!("it hangs after {told:#?}"),
            }
            if told.last().is_some_and(&is_wanted) {
                return told;
            }
        }
    }

    /// Ends it as a service manager does; it must end well. Returns what it told until then.
    pub(crate) fn terminate(mut self) -> Vec<Value> {
        signal(self.child.id(), "TERM");
        let told = self.told_until(|event| event["event"] == "stopped");
        assert!(self.child.wait().unwrap().success());
        told
    }
}

impl Daemon {
    /// Ends it as a power cut does.
    pub(crate) fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The program with these arguments, and pipes to and from it.
pub(crate) fn piped(arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_mlrd"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Sends a signal, by its name without SIG.
pub(crate) fn signal(process: u32, name: &str) {
    let mut kill = Command::new("kill");
    let killed = kill.args([&format!("-{name}"), &process.to_string()]);
    assert!(killed.status().unwrap().success());
}

/// Ends a test that waits for what will never come. No computer takes so long for anything
/// that is waited for here.
pub(crate) const HANG: Duration = Duration::from_secs(10 * 60);

/// Settings with which an identification and the search for a recovery gait do the least that they can:
/// a few seconds of work each.
pub(crate) const QUICK: &str = "
[identification]
leaders = 1
variations = [{}]
[identification.genetic]
population = 4
generations = 1
islands = 1
refine = false
[recovery]
screen_steps = 1
robots = 1
judged_robots = 1
generations = 0
";

/// The log whose robot stands for 6 s, walks, and loses legs 3 and 4 at 19 s.
pub(crate) const LOG: &str = "detect-legs3-4.csv.gz";
const START_S: f64 = 6.0;
const DAMAGE_S: f64 = 19.0;

/// What the daemon must say about [`LOG`].
pub(crate) fn expect_legs_3_and_4(daemon: &Daemon) {
    let started = daemon.next("motion_started");
    let start_s = started["motion_start_s"].as_f64().unwrap();
    assert!((start_s - START_S).abs() < 0.15, "{start_s}");
    let damage = daemon.next("damage_detected");
    let delay_s = damage["t_s"].as_f64().unwrap() - DAMAGE_S;
    assert!((2.0..3.5).contains(&delay_s), "{delay_s}");
    let is_answer = |event: &Value| ["identified", "unidentified"].contains(&name(event));
    let told = daemon.told_until(is_answer);
    let identified = told.last().unwrap();
    assert_eq!(name(identified), "identified", "{identified}");
    let legs = &identified["result"]["damaged_legs"];
    assert_eq!(legs, &serde_json::json!([3, 4]));
    assert_eq!(identified["level"], 2);
    println!(
        "motion {start_s:.2} s, damage flagged {delay_s:.2} s after it struck, identified: {} in {:.1} s",
        identified["result"]["description"].as_str().unwrap(),
        identified["result"]["elapsed_s"].as_f64().unwrap(),
    );
}

/// The name of an event.
pub(crate) fn name(event: &Value) -> &str {
    event["event"].as_str().unwrap()
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
