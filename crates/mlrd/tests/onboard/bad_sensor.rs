//! Sensors that are broken or mounted wrongly, on a real pseudo-terminal. Time is the
//! device's, as fast as the daemon reads.

use std::path::Path;

use crate::daemon::{
    Daemon, LOG,
    player::{Device, Frame, Line, Row, play_in_real_time},
};
use nalgebra::Vector3;
use serde_json::Value;

/// Nothing is explained here.
const SETTINGS: &str = "status_every_s = 0.2\nexplain = false\n";

/// Plays the bridge's frames, as fast as the line takes them, to a daemon with these
/// settings.
fn play(frames: &[Frame], settings: &str) -> Vec<Value> {
    play_by(frames, frames.len(), settings, |mut line, frames| {
        line.send_all(frames);
        line
    })
}

/// Returns everything that the daemon told up to its last of so many good frames, once it
/// is sure that they were recorded.
fn play_by(
    frames: &[Frame],
    good: usize,
    settings: &str,
    send: impl FnOnce(Line, &[Frame]) -> Line,
) -> Vec<Value> {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("mlrd.toml");
    std::fs::write(&config, format!("{SETTINGS}{settings}")).unwrap();
    let (port, recordings) = (folder.path().join("imu"), folder.path().join("recordings"));
    let daemon = Daemon::start([
        "--threads".as_ref(),
        "1".as_ref(),
        "--config".as_ref(),
        config.as_os_str(),
        "--port".as_ref(),
        port.as_os_str(),
        "--record".as_ref(),
        recordings.as_os_str(),
    ]);
    daemon.next("port_lost");
    let line = Line::plugged_in(&port);
    daemon.next("port_opened");
    let _line = send(line, frames);
    let told = daemon.told_until(|event| event["good"] == good);
    daemon.terminate();
    let path = event(&told, "recording_begun").unwrap()["path"].clone();
    let path = Path::new(path.as_str().unwrap());
    let recorded = mlr_imu::read_log(path, &mlr_imu::Columns::default()).unwrap();
    let rows = recorded.orientation.len();
    // Half a second is spent on calibration.
    assert!(rows + 700 > frames.len(), "{rows} of {}", frames.len());
    told
}

/// The first event of this name.
fn event<'a>(told: &'a [Value], name: &str) -> Option<&'a Value> {
    told.iter().find(|event| event["event"] == name)
}

fn count(told: &[Value], name: &str) -> usize {
    told.iter().filter(|event| event["event"] == name).count()
}

fn assert_nothing_concluded(told: &[Value]) {
    for name in ["damage_detected", "identified", "unidentified"] {
        assert_eq!(event(told, name), None);
    }
}

/// Of a log whose robot walks from 6 s on, and is damaged at 19 s: long enough to flag it,
/// and too short to identify it.
fn spoilt(spoil: impl FnMut(Row) -> Row) -> Vec<Frame> {
    let mut frames = Device::RegisterBurst.frames_altered(LOG, spoil);
    frames.retain(|frame| frame.time_s < 24.0);
    frames
}

/// What comes in these seconds repeats the sample before them.
fn frozen(during_s: std::ops::Range<f64>) -> Vec<Frame> {
    let mut last: Option<Row> = None;
    spoilt(move |row| {
        let shown = match last {
            Some(last) if during_s.contains(&row.time_s) => Row {
                time_s: row.time_s,
                ..last
            },
            _ => row,
        };
        last = Some(shown);
        shown
    })
}

fn zeroed(from_s: f64) -> Vec<Frame> {
    spoilt(move |row| {
        if row.time_s < from_s {
            return row;
        }
        Row {
            force_mps2: Vector3::zeros(),
            rate_radps: Vector3::zeros(),
            ..row
        }
    })
}

/// What a sensor shows that was turned over about its x axis.
fn upside_down() -> Vec<Frame> {
    let turned = |v: Vector3<f64>| Vector3::new(v.x, -v.y, -v.z);
    spoilt(move |row| Row {
        force_mps2: turned(row.force_mps2),
        rate_radps: turned(row.rate_radps),
        ..row
    })
}

#[test]
fn a_sensor_that_freezes_is_told_once_and_nothing_is_concluded_from_it() {
    let told = play(&frozen(10.0..40.0), "");
    assert!(event(&told, "motion_started").is_some());
    assert_nothing_concluded(&told);
    assert_eq!(count(&told, "sensor_fault"), 1);
    let fault = event(&told, "sensor_fault").unwrap();
    assert_eq!(
        (&fault["fault"], &fault["level"]),
        (&"frozen".into(), &2.into())
    );
    let since_s = fault["since_s"].as_f64().unwrap();
    assert!((since_s - 10.0).abs() < 0.05, "{fault}");
    assert!(fault["t_s"].as_f64().unwrap() < 11.0, "{fault}");
    assert!(
        fault["reason"].as_str().unwrap().contains("frozen"),
        "{fault}"
    );
    let last = told.last().unwrap();
    assert_eq!(
        (&last["fault"], &last["level"]),
        (&"frozen".into(), &2.into())
    );
}

#[test]
fn a_sensor_that_recovers_is_believed_again() {
    let told = play(&frozen(10.0..13.0), "");
    let position = |name| {
        told.iter()
            .position(|event| event["event"] == name)
            .unwrap()
    };
    assert!(position("sensor_fault") < position("sensor_recovered"));
    let recovered = event(&told, "sensor_recovered").unwrap();
    assert_eq!(
        (&recovered["fault"], &recovered["level"]),
        (&"frozen".into(), &0.into())
    );
    assert!((2.9..4.0).contains(&recovered["lasted_s"].as_f64().unwrap()));
    let damage_s = event(&told, "damage_detected").unwrap()["t_s"]
        .as_f64()
        .unwrap();
    assert!((21.0..22.5).contains(&damage_s), "{damage_s}");
    assert!(told.last().unwrap()["fault"].is_null());
}

#[test]
fn a_sensor_that_shows_zeros_is_told() {
    for from_s in [0.0, 10.0] {
        let told = play(&zeroed(from_s), "");
        assert_nothing_concluded(&told);
        assert_eq!(count(&told, "sensor_fault"), 1, "{told:#?}");
        let fault = event(&told, "sensor_fault").unwrap();
        assert_eq!(fault["fault"], "dead_accelerometer");
        let since_s = fault["since_s"].as_f64().unwrap();
        assert!((since_s - from_s).abs() < 0.05, "{fault}");
    }
}

#[test]
fn a_sensor_upside_down_is_told_with_the_cure_and_the_cure_cures() {
    let frames = upside_down();
    let told = play(&frames, "");
    assert_nothing_concluded(&told);
    assert_eq!(count(&told, "sensor_fault"), 1);
    let fault = event(&told, "sensor_fault").unwrap();
    assert_eq!(
        (&fault["fault"], &fault["level"]),
        (&"upside_down".into(), &2.into())
    );
    assert!(fault["t_s"].as_f64().unwrap() < 2.0, "{fault}");
    let reason = fault["reason"].as_str().unwrap();
    assert!(reason.contains("[mounting] roll_deg = 180.0"), "{reason}");
    let roll_deg = told.last().unwrap()["roll_deg"].as_f64().unwrap();
    assert!(roll_deg.abs() > 150.0, "{roll_deg}");

    let cured = play(&frames, "[mounting]\nroll_deg = 180.0\n");
    assert_eq!(event(&cured, "sensor_fault"), None);
    assert!(event(&cured, "damage_detected").is_some());
}

/// Their clock is that of the computer: they are played at the speed of life.
#[test]
fn modules_that_fuse_themselves_are_watched_as_well() {
    // 1.5 s of standing, 2 s of walking, and 4 s that repeat one sample.
    const BEGIN_S: f64 = 4.5;
    let frozen_from = |device: Device| {
        let mut last: Option<Row> = None;
        let frames = device.frames_altered(LOG, |row| {
            let shown = last.filter(|_| row.time_s > 8.0).unwrap_or(row);
            last = Some(shown);
            Row {
                time_s: row.time_s - BEGIN_S,
                ..shown
            }
        });
        let wanted = |frame: &Frame| (0.0..7.5).contains(&frame.time_s);
        frames.into_iter().filter(wanted).collect::<Vec<Frame>>()
    };
    let story = |device: Device| {
        let frames = frozen_from(device);
        let good = frames.len() * device.frames_per_sample();
        play_by(&frames, good, "", |line, frames| {
            play_in_real_time(line, frames, false)
        })
    };
    std::thread::scope(|scope| {
        for device in [Device::Witmotion, Device::Teapot] {
            scope.spawn(move || {
                let told = story(device);
                assert_nothing_concluded(&told);
                assert_eq!(count(&told, "sensor_fault"), 1, "{device:?}");
                assert_eq!(event(&told, "sensor_fault").unwrap()["fault"], "frozen");
            });
        }
    });
}
