//! Every number of a robot and a gait is checked, and refused by its name.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod toml_numbers;

use mlr_model::{Gait, ModelError, Robot};
use toml::Value;

/// Sets each number of the file to this, and hands the path and what comes of it on.
fn with_each_number(
    text: &str,
    number: f64,
    read: impl Fn(&str) -> Result<(), ModelError>,
    mut judge: impl FnMut(&str, Result<(), ModelError>),
) {
    let good: Value = text.parse::<toml::Table>().unwrap().into();
    let paths = toml_numbers::paths(&good);
    assert!(!paths.is_empty());
    for path in paths {
        let mut bad = good.clone();
        *toml_numbers::at(&mut bad, &path) = Value::Float(number);
        judge(&path, read(&toml::to_string(&bad).unwrap()));
    }
}

/// A gait that is a joint trajectory.
const TRAJECTORY: &str = "name = \"nod\"\nperiod_s = 1.0\nrow_s = 0.02\n\
    joints_rad = [\n  [0.1, 0.5, -1.8],\n  [0.2, 0.5, -1.8],\n]\n";

fn robot(text: &str) -> Result<(), ModelError> {
    Robot::from_toml(text).map(|_| ())
}

fn gait(text: &str) -> Result<(), ModelError> {
    Gait::from_toml(text).map(|_| ())
}

#[test]
fn the_files_as_they_are_are_accepted() {
    robot(Robot::JETHEXA_TOML).unwrap();
    gait(Gait::TRIPOD_TOML).unwrap();
    gait(TRAJECTORY).unwrap();
}

#[test]
fn what_is_no_number_or_too_large_is_refused_by_name_and_line() {
    for number in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300] {
        let refused = |path: &str, outcome: Result<(), ModelError>| {
            let ModelError::Setting(error) = outcome.expect_err(path) else {
                panic!("{path} is not named");
            };
            assert_eq!(error.name, path);
            assert!(error.line.is_some(), "{error}");
        };
        with_each_number(Robot::JETHEXA_TOML, number, robot, refused);
        with_each_number(Gait::TRIPOD_TOML, number, gait, refused);
        with_each_number(TRAJECTORY, number, gait, refused);
    }
}

#[test]
fn lengths_masses_and_times_of_zero_or_less_are_refused_by_name() {
    // These may be zero, or point the other way.
    let free = [
        "center_of_mass_m",
        "posture_deg",
        "locked_deg",
        "hip_m",
        "hip_yaw_deg",
        "nominal_foot_m",
        "stride_m",
        "joints_rad",
    ];
    let may_be_zero = [
        "damping_nm_s_per_rad",
        "latency_s",
        "ramp_s",
        "lift_m",
        "phase_offsets",
    ];
    for number in [0.0, -1.0] {
        let judge = |path: &str, outcome: Result<(), ModelError>| {
            let among = |keys: &[&str]| keys.iter().any(|key| path.contains(key));
            if among(&free) || (number == 0.0 && among(&may_be_zero)) {
                outcome.expect(path);
                return;
            }
            let ModelError::Setting(error) = outcome.expect_err(path) else {
                panic!("{path} is not named");
            };
            assert_eq!(error.name, path);
        };
        with_each_number(Robot::JETHEXA_TOML, number, robot, judge);
        with_each_number(Gait::TRIPOD_TOML, number, gait, judge);
        with_each_number(TRAJECTORY, number, gait, judge);
    }
}

#[test]
fn a_robot_that_cannot_touch_the_ground_is_refused() {
    let lines = Robot::JETHEXA_TOML.lines();
    let without: Vec<&str> = lines.filter(|line| !line.starts_with("contact")).collect();
    let message = robot(&without.join("\n")).unwrap_err().to_string();
    assert!(message.contains("a link with a contact"), "{message}");
}
