//! The daemon on a real pseudo-terminal, fed with a stand-in log in the bridge's
//! framing. Time is the device's, so the log plays as fast as the daemon reads.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod daemon;

use std::{path::Path, process::Command, thread, time::Duration};

use daemon::{
    Daemon, LOG, QUICK, expect_legs_3_and_4,
    player::{Device, Line, corrupt},
};

/// The daemon is started before the port is plugged in: a process started later
/// would inherit the master's end and never see it unplugged.
fn daemon_on(port: &Path, more: &[&str]) -> Daemon {
    let port = port.to_str().unwrap();
    Daemon::start(["--port", port, "--threads", "2"].iter().chain(more))
}

#[test]
fn notices_identifies_records_and_remembers() {
    let folder = tempfile::tempdir().unwrap();
    let port = folder.path().join("imu");
    let (state, recordings) = (
        folder.path().join("state"),
        folder.path().join("recordings"),
    );
    let config = folder.path().join("mlrd.toml");
    std::fs::write(&config, format!("explain = false\n{QUICK}")).unwrap();
    let more = [
        "--config",
        config.to_str().unwrap(),
        "--state-dir",
        state.to_str().unwrap(),
        "--record",
        recordings.to_str().unwrap(),
    ];
    let daemon = daemon_on(&port, &more);
    assert!(daemon.next("started").get("last_known").is_none());
    daemon.next("port_lost");
    let mut line = Line::plugged_in(&port);
    daemon.next("port_opened");
    let mut frames = Device::RegisterBurst.frames(LOG);
    corrupt(&mut frames);
    let rows = frames.len();
    let player = thread::spawn(move || {
        for frame in &frames {
            line.send(&frame.bytes);
        }
        line
    });
    let recording = daemon.next("recording_begun")["path"].clone();
    expect_legs_3_and_4(&daemon);
    let mut line = player.join().unwrap();
    let offer = daemon.next("recovery_gait");
    assert_eq!(offer["result"]["schema"], "mlr.recovery/1");
    assert_eq!(offer["result"]["folded_legs"], serde_json::json!([3, 4]));
    for (file, name) in [("gait", "recovery-1.toml"), ("joints", "recovery-1.csv")] {
        let path = Path::new(offer[file].as_str().unwrap());
        assert_eq!(path, state.join(name));
        assert!(path.is_file());
    }
    let gait = std::fs::read_to_string(offer["gait"].as_str().unwrap()).unwrap();
    assert!(
        mlr_model::Gait::from_toml(&gait)
            .unwrap()
            .cycle_s()
            .is_some()
    );
    line.unplug();
    daemon.next("port_lost");
    daemon.terminate();

    let recorded = mlr_imu::read_log(
        Path::new(recording.as_str().unwrap()),
        &mlr_imu::Columns::default(),
    )
    .unwrap()
    .orientation;
    assert!(
        recorded.len() > rows * 95 / 100,
        "{} of {rows}",
        recorded.len()
    );

    let again = daemon_on(&port, &more);
    let known = again.next("started")["last_known"].clone();
    assert_eq!(known["damaged_legs"], serde_json::json!([3, 4]));
    again.terminate();
}

#[test]
fn a_port_that_is_not_there_is_waited_for() {
    let daemon = Daemon::start(["--port", "/dev/none-such"]);
    let lost = daemon.next("port_lost");
    assert_eq!(lost["level"], 3);
    let reason = lost["reason"].as_str().unwrap();
    assert!(reason.contains("/dev/none-such") && reason.contains("does not exist"));
    daemon.terminate();
}

#[test]
fn a_port_that_another_program_holds_is_said_to_be_held() {
    let folder = tempfile::tempdir().unwrap();
    let port = folder.path().join("imu");
    let _line = Line::plugged_in(&port);
    let first = daemon_on(&port, &[]);
    first.next("port_opened");
    let second = daemon_on(&port, &[]);
    let reason = second.next("port_lost")["reason"].clone();
    assert!(
        reason.as_str().unwrap().contains("held by another program"),
        "{reason}"
    );
    first.terminate();
    second.next("port_opened");
    second.terminate();
}

#[test]
fn a_line_that_makes_no_sense_is_told_why() {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("mlrd.toml");
    std::fs::write(&config, "status_every_s = 0.2\nformat = 'witmotion'\n").unwrap();
    let port = folder.path().join("imu");
    let daemon = daemon_on(&port, &["--config", config.to_str().unwrap()]);
    daemon.next("port_lost");
    let mut line = Line::plugged_in(&port);
    daemon.next("port_opened");
    let teapot = Device::Teapot.frames(LOG);
    let player = thread::spawn(move || {
        for frame in teapot.iter().take(400) {
            line.send(&frame.bytes);
            thread::sleep(Duration::from_millis(10));
        }
        line
    });
    let fault = daemon.next("line_fault");
    assert_eq!(fault["level"], 2);
    assert!(
        fault["reason"].as_str().unwrap().contains("teapot"),
        "{fault}"
    );
    let _line = player.join().unwrap();
    let stale = loop {
        let status = daemon.next("status");
        if status["level"] == 3 {
            break status;
        }
    };
    assert!(stale["silent_s"].as_f64().unwrap() > 2.0);
    daemon.terminate();
}

#[test]
fn a_status_shows_tilt_and_rate_once_they_are_known() {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("mlrd.toml");
    std::fs::write(&config, "status_every_s = 0.2\n").unwrap();
    let port = folder.path().join("imu");
    let daemon = daemon_on(&port, &["--config", config.to_str().unwrap()]);
    let before = daemon.next("status");
    for unknown in ["roll_deg", "pitch_deg", "rate_hz", "fault"] {
        assert!(
            before.get(unknown).is_some_and(serde_json::Value::is_null),
            "{before}"
        );
    }
    let mut line = Line::plugged_in(&port);
    daemon.next("port_opened");
    let frames = Device::RegisterBurst.frames(LOG);
    // The robot stands, rolled and pitched by a third of a degree.
    line.send_all(&frames[..2000]);
    let told = daemon.told_until(|event| event["good"] == 2000);
    // The samples are uneven: a few of them, between two status, show no rate.
    let status = std::iter::once(&before).chain(&told);
    let status: Vec<_> = status.filter(|event| event["event"] == "status").collect();
    let good = |status: &serde_json::Value| status["good"].as_u64().unwrap();
    let rates_hz: Vec<f64> = status
        .windows(2)
        .filter(|pair| good(pair[1]) >= good(pair[0]) + 100)
        .filter_map(|pair| pair[1]["rate_hz"].as_f64())
        .collect();
    assert!(!rates_hz.is_empty());
    assert!(
        rates_hz.iter().all(|hz| (900.0..1050.0).contains(hz)),
        "{rates_hz:?}"
    );
    let after = told.last().unwrap();
    for (angle, expected_deg) in [("roll_deg", -0.37), ("pitch_deg", -0.34)] {
        let angle_deg = after[angle].as_f64().unwrap();
        assert!((angle_deg - expected_deg).abs() < 0.3, "{after}");
    }
    let silent = daemon
        .told_until(|event| event["event"] == "status")
        .pop()
        .unwrap();
    assert!(silent["rate_hz"].is_null(), "{silent}");
    assert_eq!(silent["roll_deg"], after["roll_deg"]);
    assert_eq!(silent["dropped_status"], 0);
    daemon.terminate();
}

#[test]
fn settings_that_make_no_sense_end_it_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("mlrd.toml");
    for (text, told) in [
        ("port = '/dev/ttyTHS1'\nbauds = 9600", "bauds"),
        (
            "port = '/dev/ttyTHS1'\n[mounting]\nroll_deg = 1000.0",
            "mounting.roll_deg",
        ),
        ("port = '/dev/a'\ni2c = '/dev/b'", "more than one of port"),
        ("", "expected port, i2c or stdin"),
    ] {
        std::fs::write(&config, text).unwrap();
        let output = Command::new(env!("CARGO_BIN_EXE_mlrd"))
            .args(["--config", config.to_str().unwrap()])
            .output()
            .unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(stderr.contains(told), "{stderr}");
    }
}
