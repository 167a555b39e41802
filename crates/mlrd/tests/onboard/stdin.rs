//! Samples that another program hands on.

use std::{
    io::Write as _,
    process::{Command, Output, Stdio},
};

use crate::daemon::piped;
use mlr_imu::{Columns, read_log};
use serde_json::Value;

/// What the daemon says to this text, and its messages.
fn said_to(text: &[u8], more: &[&str]) -> (Vec<Value>, Output) {
    let alone = ["--stdin", "--no-explain", "--no-recover", "--no-learn"];
    let mut child = piped(&[&alone, more].concat());
    let mut stdin = child.stdin.take().unwrap();
    stdin.write_all(text).unwrap();
    // The end of its input.
    drop(stdin);
    let output = child.wait_with_output().unwrap();
    let events = output.stdout.split(|byte| *byte == b'\n');
    let events = events.filter(|line| !line.is_empty());
    let events = events.map(|line| serde_json::from_slice(line).unwrap());
    (events.collect(), output)
}

fn names(events: &[Value]) -> Vec<&str> {
    let names = events.iter().map(|event| event["event"].as_str().unwrap());
    names.filter(|name| *name != "status").collect()
}

/// A body that stands for two seconds and rocks from then on, at 100 Hz; a line in a hundred
/// makes no sense.
fn rows() -> Vec<String> {
    let row = |index: u32| {
        let time_s = f64::from(index) * 0.01;
        let moving_s = (time_s - 2.0).max(0.0);
        // No sensor says the same twice.
        let noise = f64::from((index * 7919) % 1009) * 1e-6;
        let roll = 0.05 * (9.0 * moving_s).sin() + noise;
        match index % 100 {
            50 => "0.5,what".into(),
            _ => format!("{time_s:.3},{roll:.7},{:.7},{noise:.7}", noise - 0.01),
        }
    };
    (0..800).map(row).collect()
}

#[test]
fn a_table_is_watched_and_recorded_and_its_end_is_the_daemons() {
    let folder = tempfile::tempdir().unwrap();
    let record = folder.path().to_str().unwrap();
    // The last line has no end.
    let text = format!("t_s,roll_rad,pitch_rad,yaw_rad\n{}", rows().join("\n"));
    let (events, output) = said_to(text.as_bytes(), &["--record", record]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let names = names(&events);
    assert_eq!(events[0]["port"], "stdin");
    assert!(names.contains(&"motion_started"), "{names:?}");
    assert_eq!(names.last(), Some(&"stopped"), "{names:?}");

    let recorded = std::fs::read_dir(record).unwrap().next().unwrap().unwrap();
    let recorded = read_log(recorded.path(), &Columns::default()).unwrap();
    let times_s = recorded.orientation.times_s();
    // Eight lines made no sense; the filter against spikes holds back a few.
    assert!((785..=792).contains(&times_s.len()), "{}", times_s.len());
    assert!((times_s[times_s.len() - 1] - 7.99).abs() < 0.05);
}

#[test]
fn objects_are_read_and_bad_lines_counted() {
    let object = |row: &String| {
        let fields: Vec<&str> = row.split(',').collect();
        match fields[..] {
            [t, roll, pitch, yaw] => format!(
                "{{\"t_s\":{t},\"roll_rad\":{roll},\"pitch_rad\":{pitch},\"yaw_rad\":{yaw}}}\n"
            ),
            _ => "{\"t_s\":\n".into(),
        }
    };
    let text: String = rows().iter().map(object).collect();
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("mlrd.toml");
    std::fs::write(&config, "status_every_s = 0.1\n").unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_mlrd"));
    child.args([
        "--stdin",
        "--no-explain",
        "--config",
        config.to_str().unwrap(),
    ]);
    let mut child = child
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    stdin.write_all(text.as_bytes()).unwrap();
    let events = std::io::BufReader::new(child.stdout.take().unwrap());
    let mut events = std::io::BufRead::lines(events);
    let counted = events.find_map(|line| {
        let event: Value = serde_json::from_str(&line.unwrap()).unwrap();
        (event["event"] == "status" && event["good"] == 792).then_some(event)
    });
    assert_eq!(counted.unwrap()["bad"], 8);
    drop(stdin);
    assert!(child.wait().unwrap().success());
}

#[test]
fn one_source_is_expected() {
    let run = |arguments: &[&str]| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_mlrd"));
        let output = program
            .args(arguments)
            .stdin(Stdio::null())
            .output()
            .unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{message}");
        message
    };
    let message = run(&["--stdin", "--port", "/dev/ttyTHS1"]);
    assert!(message.contains("cannot be used with"), "{message}");
    let message = run(&[]);
    assert!(message.contains("expected port, i2c or stdin"), "{message}");
}
