//! The daemon on a real pseudo-terminal, fed with the raw samples of a stand-in
//! log in the bridge's framing. Time is the device's, so the log plays as fast as
//! the daemon reads.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::{
    fs::File,
    io::{BufRead, BufReader, Write},
    path::Path,
    process::{Command, Stdio},
    sync::mpsc,
    thread,
    time::Duration,
};

use flate2::bufread::GzDecoder;
use mlr_imu::{
    STANDARD_GRAVITY_MPS2,
    frames::{MlrPayload, encode_mlr},
};
use serde_json::Value;
use serialport::{SerialPort, TTYPort};

/// The frames that a bridge would have sent while the log was recorded.
fn frames(log: &str) -> Vec<Vec<u8>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../data/logs/stand-in")
        .join(log);
    let text = GzDecoder::new(BufReader::new(File::open(path).unwrap()));
    let mut reader = csv::Reader::from_reader(text);
    (0_u8..=255)
        .cycle()
        .zip(reader.records())
        .map(|(counter, row)| {
            let row = row.unwrap();
            let number = |column: usize| row[column].parse::<f64>().unwrap();
            let mut burst = [0; 14];
            for axis in 0..3 {
                let force = number(1 + axis) / STANDARD_GRAVITY_MPS2 * 16384.0;
                let rate = number(4 + axis).to_degrees() * 131.0;
                burst[2 * axis..][..2].copy_from_slice(&(force.round() as i16).to_be_bytes());
                burst[8 + 2 * axis..][..2].copy_from_slice(&(rate.round() as i16).to_be_bytes());
            }
            let device_time_us = (number(0) * 1e6).round() as u32;
            encode_mlr(&MlrPayload::RegisterBurst(burst), counter, device_time_us)
        })
        .collect()
}

#[test]
fn notices_and_identifies_damage_and_survives_a_bad_line() {
    // The port is plugged in after the daemon has started; a daemon started later
    // would inherit the master's end and never see it unplugged.
    let folder = tempfile::tempdir().unwrap();
    let port = folder.path().join("imu");
    let mut daemon = Command::new(env!("CARGO_BIN_EXE_mlrd"))
        .arg("--port")
        .arg(&port)
        .args(["--threads", "2"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let (send, lines) = mpsc::channel();
    let stdout = BufReader::new(daemon.stdout.take().unwrap());
    thread::spawn(move || {
        for line in stdout.lines() {
            let event: Value = serde_json::from_str(&line.unwrap()).unwrap();
            if send.send(event).is_err() {
                return;
            }
        }
    });
    let next = |wanted: &str| -> Value {
        loop {
            let event = lines.recv_timeout(Duration::from_secs(120)).unwrap();
            if event["event"] == wanted {
                return event;
            }
        }
    };
    next("started");
    next("port_lost");
    let (mut master, slave) = TTYPort::pair().unwrap();
    std::os::unix::fs::symlink(slave.name().unwrap(), &port).unwrap();
    next("port_opened");
    let player = thread::spawn(move || {
        master.set_timeout(Duration::from_secs(60)).unwrap();
        for (index, mut frame) in frames("detect-legs3-4.csv.gz").into_iter().enumerate() {
            // One byte in a hundred frames arrives wrong.
            if index % 100 == 50 {
                frame[8] ^= 0x40;
            }
            master.write_all(&frame).unwrap();
        }
        master
    });

    let start_s = next("motion_started")["motion_start_s"].as_f64().unwrap();
    assert!((start_s - 6.0).abs() < 0.15, "{start_s}");
    let damage = next("damage_detected");
    let delay_s = damage["t_s"].as_f64().unwrap() - 19.0;
    assert!((2.0..3.5).contains(&delay_s), "{delay_s}");
    let identified = next("identified");
    assert_eq!(
        identified["result"]["damaged_legs"],
        serde_json::json!([3, 4])
    );
    assert_eq!(identified["level"], 2);

    let master = player.join().unwrap();
    drop((master, slave));
    next("port_lost");
    let killed = Command::new("kill")
        .args(["-TERM", &daemon.id().to_string()])
        .status()
        .unwrap();
    assert!(killed.success());
    next("stopped");
    assert!(daemon.wait().unwrap().success());
}

#[test]
fn a_port_that_is_not_there_is_waited_for() {
    let mut daemon = Command::new(env!("CARGO_BIN_EXE_mlrd"))
        .args(["--port", "/dev/none-such"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(daemon.stdout.take().unwrap()).lines();
    let mut next = || -> Value { serde_json::from_str(&lines.next().unwrap().unwrap()).unwrap() };
    assert_eq!(next()["event"], "started");
    let lost = next();
    assert_eq!(lost["event"], "port_lost");
    assert_eq!(lost["level"], 3);
    assert!(lost["reason"].as_str().unwrap().contains("/dev/none-such"));
    assert!(daemon.try_wait().unwrap().is_none(), "it goes on trying");
    daemon.kill().unwrap();
    daemon.wait().unwrap();
}
