//! Ten minutes of frames at 1 kHz, with identifications beside them:
//!
//! ```text
//! cargo test --release -p mlrd --test onboard -- load --ignored --nocapture
//! ```
#![allow(clippy::print_stdout, reason = "what was measured is shown")]

use std::{fs, thread, time::Duration};

use crate::daemon::{
    Daemon, LOG,
    player::{Device, Line, play_in_real_time},
};

const READING_ALONE_S: f64 = 60.0;
const LOAD_S: f64 = 600.0;

/// What a process has used so far.
#[derive(Debug, Clone, Copy)]
struct Usage {
    cpu_s: f64,
    resident_mb: f64,
}

impl Usage {
    fn of(process: u32) -> Self {
        // Fields 14 and 15 of proc(5): clock ticks of 10 ms in user and kernel mode.
        let stat = fs::read_to_string(format!("/proc/{process}/stat")).unwrap();
        let fields = crate::daemon::stat_fields(&stat);
        let ticks: f64 = fields[11..13]
            .iter()
            .map(|f| f.parse::<f64>().unwrap())
            .sum();
        let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap();
        let resident = status
            .lines()
            .find(|line| line.starts_with("VmRSS"))
            .unwrap();
        let kb: f64 = resident.split_whitespace().nth(1).unwrap().parse().unwrap();
        Self {
            cpu_s: ticks / 100.0,
            resident_mb: kb / 1024.0,
        }
    }
}

/// Plays a log to a daemon of its own; returns its usage and its last status.
fn play(log: &str, duration_s: f64, wanted: &str) -> (Usage, serde_json::Value, usize) {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("mlrd.toml");
    fs::write(&config, "status_every_s = 1.0\n").unwrap();
    let port = folder.path().join("imu");
    let daemon = Daemon::start([
        "--port",
        port.to_str().unwrap(),
        "--config",
        config.to_str().unwrap(),
        "--state-dir",
        folder.path().join("state").to_str().unwrap(),
    ]);
    daemon.next("port_lost");
    let line = Line::plugged_in(&port);
    daemon.next("port_opened");
    let frames = Device::RegisterBurst.frames_at_1_khz(log, duration_s);
    let sent = frames.len();
    let before = Usage::of(daemon.id());
    let line = play_in_real_time(line, &frames, false);
    // Until the last bytes are through.
    thread::sleep(Duration::from_secs(3));
    let after = Usage::of(daemon.id());
    if !wanted.is_empty() {
        daemon.next(wanted);
    }
    let status = loop {
        let status = daemon.next("status");
        if status["silent_s"].as_f64().unwrap() > 1.0 {
            break status;
        }
    };
    drop(line);
    daemon.terminate();
    let usage = Usage {
        cpu_s: after.cpu_s - before.cpu_s,
        resident_mb: after.resident_mb,
    };
    (usage, status, sent)
}

#[test]
#[ignore = "takes eleven minutes"]
fn ten_minutes_at_1_khz() {
    let (usage, status, sent) = play("healthy.csv.gz", READING_ALONE_S, "");
    let share = usage.cpu_s / READING_ALONE_S;
    println!(
        "reading alone: {:.2} % of a core, {:.1} MB resident, {} of {sent} frames",
        100.0 * share,
        usage.resident_mb,
        status["good"]
    );
    assert_eq!(status["good"], sent);
    assert!(share < 0.05 && usage.resident_mb < 50.0, "{usage:?}");

    let (usage, status, sent) = play(LOG, LOAD_S, "identified");
    println!(
        "with identifications: {:.2} % of a core, {:.1} MB resident, {} of {sent} frames, {} bad, {} lost",
        100.0 * usage.cpu_s / LOAD_S,
        usage.resident_mb,
        status["good"],
        status["bad"],
        status["lost"]
    );
    assert_eq!(status["good"], sent);
    assert_eq!((&status["bad"], &status["lost"]), (&0.into(), &0.into()));
}
