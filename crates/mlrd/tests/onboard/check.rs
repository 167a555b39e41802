//! `mlrd check` on real pseudo-terminals, each with one thing wrong.

use std::{
    fs,
    path::Path,
    process::{Command, Output},
    thread,
    time::Duration,
};

use crate::daemon::player::{Device, Frame, Line, Row};
use nalgebra::{Rotation3, Vector3};
use serde_json::Value;

/// What `mlrd check` prints about a port, and its exit status.
struct Checked {
    status: i32,
    report: Value,
}

impl Checked {
    fn of(output: &Output) -> Self {
        Self {
            status: output.status.code().unwrap(),
            report: serde_json::from_slice(&output.stdout).unwrap(),
        }
    }

    /// Mark and cure of one check.
    fn found(&self, check: &str) -> (&str, &str, &str) {
        let checks = self.report["checks"].as_array().unwrap();
        let finding = checks.iter().find(|finding| finding["check"] == check);
        let finding = finding.unwrap_or_else(|| panic!("{check}: {:#}", self.report));
        let text = |name: &str| finding[name].as_str().unwrap_or_default();
        (text("mark"), text("found"), text("cure"))
    }

    /// This check failed, and nothing else did.
    fn failed(&self, check: &str) -> (&str, &str) {
        let (mark, found, cure) = self.found(check);
        assert_eq!((mark, self.status), ("failed", 1), "{:#}", self.report);
        let checks = self.report["checks"].as_array().unwrap();
        let failed = checks.iter().filter(|one| one["mark"] == "failed");
        assert_eq!(failed.count(), 1, "{:#}", self.report);
        (found, cure)
    }
}

fn command(folder: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mlrd"));
    command.args(["check", "--json", "--state-dir"]);
    command.arg(folder.join("state")).args(more);
    command
}

fn check(folder: &Path, more: &[&str]) -> Checked {
    Checked::of(&command(folder, more).output().unwrap())
}

/// Checks a port, to which these bytes are sent again and again, ten milliseconds apart.
fn check_line(pieces: Vec<Vec<u8>>, more: &[&str]) -> Checked {
    let folder = tempfile::tempdir().unwrap();
    let port = folder.path().join("imu");
    let mut line = Line::plugged_in(&port);
    // The line is full once nobody listens any more: the player then waits until the test ends.
    thread::spawn(move || {
        for piece in pieces.iter().cycle() {
            line.send(piece);
            thread::sleep(Duration::from_millis(10));
        }
    });
    let arguments: Vec<&str> = ["--port", port.to_str().unwrap()]
        .into_iter()
        .chain(more.iter().copied())
        .collect();
    check(folder.path(), &arguments)
}

/// What a sensor shows of a robot at rest, at 1 kHz by the device's clock, whose
/// accelerations a fault alters.
fn resting(alter: impl Fn(Vector3<f64>) -> Vector3<f64>) -> Vec<Vec<u8>> {
    let rows: Vec<Row> = (0..60_000)
        .map(|index: u32| {
            let noise = f64::from(index * 7919 % 101) * 1e-3;
            Row {
                time_s: f64::from(index) * 1e-3,
                force_mps2: alter(Vector3::new(noise, -noise, 9.807)),
                rate_radps: Vector3::repeat(noise * 0.05),
                angles_rad: Vector3::zeros(),
            }
        })
        .collect();
    let frames = Device::RegisterBurst.frames_of(&rows);
    let bytes = |frames: &[Frame]| {
        frames
            .iter()
            .flat_map(|frame| frame.bytes.clone())
            .collect()
    };
    frames.chunks(10).map(bytes).collect()
}

#[test]
fn a_healthy_robot_is_all_well_and_its_computer_measured() {
    let checked = check_line(resting(|force| force), &[]);
    assert_eq!(checked.status, 0, "{:#}", checked.report);
    assert_eq!(checked.report["schema"], "mlr.check/1");
    assert_eq!(checked.report["mark"], "ok", "{:#}", checked.report);
    assert!(checked.found("framing").1.starts_with("mlr: "));
    let speed = &checked.report["speed"];
    let walks_per_s = speed["walks_per_s"].as_f64().unwrap();
    assert!(walks_per_s > 0.0);
    let estimates = speed["estimates"].as_array().unwrap();
    assert_eq!(estimates.len(), 3, "{estimates:?}");
    for estimate in estimates {
        assert!(estimate["estimated_s"].as_f64().unwrap() > 0.0);
    }
}

#[test]
fn a_silent_port_is_a_matter_of_wires() {
    let checked = check_line(vec![Vec::new()], &[]);
    let (found, cure) = checked.failed("framing");
    assert!(found.contains("no byte"), "{found}");
    assert!(cure.contains("TX is wired"), "{cure}");
}

#[test]
fn garbage_is_a_matter_of_speed_or_framing() {
    let garbage: Vec<u8> = (0..100_u32).map(|i| (i * i * 31 + 7) as u8).collect();
    let checked = check_line(vec![garbage], &[]);
    let (found, cure) = checked.failed("framing");
    assert!(found.contains("no valid frame"), "{found}");
    assert!(cure.contains("no usual speed"), "{cure}");
    let other = check_line(resting(|force| force), &["--format", "teapot"]);
    let (found, cure) = other.failed("framing");
    assert!(found.contains("mlr frames"), "{found}");
    assert_eq!(cure, "--format mlr");
}

#[test]
fn a_tilted_sensor_and_a_wrong_range_are_told_with_the_settings_that_cure_them() {
    let tilt = Rotation3::from_axis_angle(&Vector3::x_axis(), 20_f64.to_radians());
    let checked = check_line(resting(|force| tilt * force), &[]);
    let (found, cure) = checked.failed("mounting");
    assert!(found.contains("roll -20."), "{found}");
    assert!(cure.contains("[mounting] roll_deg = -20."), "{cure}");

    let upside_down = check_line(resting(|force| -force), &[]);
    let (found, cure) = upside_down.failed("mounting");
    assert!(found.contains("upside down"), "{found}");
    assert!(cure.contains("[mounting] roll_deg = 180.0"), "{cure}");

    let quarter = check_line(resting(|force| force / 4.0), &[]);
    let (_, cure) = quarter.failed("gravity");
    assert!(cure.contains("accelerometer = \"g8\""), "{cure}");
}

#[test]
fn what_is_missing_or_broken_is_named_before_anything_is_listened_to() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let checked = check(path, &["--port", "/dev/none-such"]);
    let (found, cure) = checked.failed("port");
    assert_eq!(found, "/dev/none-such does not exist");
    assert!(cure.contains("This computer has"), "{cure}");
    assert!(!path.join("state").exists(), "nothing is made");

    let config = path.join("mlrd.toml");
    fs::write(&config, "baud = 9600\nbauds = 9600\n").unwrap();
    let broken = check(path, &["--config", config.to_str().unwrap()]);
    let (found, cure) = broken.failed("settings");
    assert!(
        found.contains("line 2") && found.contains("bauds"),
        "{found}"
    );
    assert!(cure.contains("correct the file"), "{cure}");

    let atlas = path.join("jethexa.atlas");
    fs::write(&atlas, "no atlas").unwrap();
    let arguments = ["--stdin", "--atlas", atlas.to_str().unwrap()];
    let spoilt = check(path, &arguments);
    let (mark, _, cure) = spoilt.found("atlas");
    assert_eq!((mark, spoilt.status), ("failed", 1));
    assert!(cure.contains("mlr-ga atlas build -o"), "{cure}");

    let state = path.join("state");
    fs::create_dir(&state).unwrap();
    fs::write(state.join("calibration.json"), "{").unwrap();
    let unreadable = check(path, &["--port", "/dev/none-such"]);
    assert_eq!(unreadable.found("calibration").0, "warning");
    let kept = fs::read_to_string(state.join("calibration.json")).unwrap();
    assert_eq!(kept, "{", "nothing is set aside");

    let usage = command(path, &["--baud", "0"]).output().unwrap();
    assert_eq!(usage.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&usage.stderr).contains("--baud"));
}
