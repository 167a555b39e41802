//! Stopped in the middle of long work, as by Ctrl-C.
#![cfg(unix)]

use std::{
    fs,
    os::unix::process::ExitStatusExt,
    process::{Command, Stdio},
    thread,
    time::Duration,
};

use assert_cmd::cargo::cargo_bin;
use rustix::process::{Pid, Signal, kill_process};

/// Long enough for the file to be reserved, far too short for any answer.
const AT_WORK: Duration = Duration::from_secs(2);

/// Does what Ctrl-C does, the program having no handler for either, and works for jobs in the
/// background too, which ignore that.
const STOP: Signal = Signal::TERM;

/// Stops the program while it works on a new file in an empty folder: nothing may be in
/// there afterwards, nor on stdout.
fn leaves_nothing_behind(arguments: &[&str], new_file: &str) {
    let folder = tempfile::tempdir().unwrap();
    let program = Command::new(cargo_bin!("mlr-ga"))
        .args(arguments)
        .arg("-o")
        .arg(folder.path().join(new_file))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    let mut program = program.unwrap();
    thread::sleep(AT_WORK);
    assert_eq!(program.try_wait().unwrap(), None, "still at work");
    kill_process(Pid::from_child(&program), STOP).unwrap();
    let output = program.wait_with_output().unwrap();
    assert_eq!(output.status.signal(), Some(STOP.as_raw()));
    assert!(output.stdout.is_empty(), "no partial result");
    let left: Vec<_> = fs::read_dir(folder.path()).unwrap().collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn an_explanation() {
    let log = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../data/logs/stand-in/undeclared-c.csv.gz"
    );
    leaves_nothing_behind(&["explain", log, "--json"], "new.json");
}

#[test]
fn an_atlas() {
    leaves_nothing_behind(&["atlas", "build"], "new.atlas");
}
