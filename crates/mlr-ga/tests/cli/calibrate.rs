//! `calibrate`, and what other commands make of the description that it writes, through the program.

use std::fs;

use crate::program::Folder;
use mlr_model::{Robot, RobotParameter};
use serde_json::Value;

/// A robot of its own: a sensor tilted by a degree, a femur's horn and the clock a little off.
fn own_robot(folder: &Folder) -> (Robot, String) {
    let changes = [
        (RobotParameter::ImuMounting(0), 1.0),
        (RobotParameter::JointZero { leg: 2, joint: 1 }, 0.02),
        (RobotParameter::Clock, 0.002),
    ];
    let change = |robot: Robot, (one, by)| robot.with_added(one, by);
    let robot = changes.into_iter().fold(Robot::jethexa(), change);
    let text = robot.written_into(Robot::JETHEXA_TOML).unwrap();
    (robot, folder.write("own.toml", text))
}

fn walk_of(folder: &Folder, name: &str, robot: &str, more: &[&str]) -> String {
    let log = folder.path(name);
    let mut arguments = vec!["simulate", "-o", &log, "--robot", robot, "--walk-s", "8"];
    // Gears have play, whatever the description says.
    arguments.extend(["--backlash-rad", "0.006"]);
    arguments.extend(more);
    folder.succeeds(&arguments);
    log
}

#[test]
fn a_robot_is_calibrated_by_its_walk_and_known_from_then_on() {
    let folder = Folder::new();
    let (own, described) = own_robot(&folder);
    let log = walk_of(&folder, "healthy.csv", &described, &[]);
    let calibrated = folder.path("my-robot.toml");
    let output = folder
        .program(&["calibrate", &log, "--healthy", "--json", "-o", &calibrated])
        .output()
        .unwrap();
    assert!(output.status.success());
    // What the walk does not tell is said.
    let warning = String::from_utf8(output.stderr).unwrap();
    assert!(
        warning.contains("do not tell") && warning.contains("body_mass"),
        "{warning}"
    );
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["schema"], "mlr.calibration/1");
    let walk = &report["walks"][0];
    assert_eq!(walk["log"], Value::from(log.clone()));
    assert_eq!(walk["sha256"].as_str().unwrap().len(), 64);
    let error = |when: &str| walk[when]["validation_deg"].as_f64().unwrap();
    assert!(error("error_after") < 0.5 * error("error_before"));
    // The sensor is tilted about the roll axis. That a whole robot turns by a fraction of a degree is its zeros' doing,
    // and a walk does not tell those.
    let roll = |when: &str| walk[when]["validation_axes_deg"][0].as_f64().unwrap();
    assert!(roll("error_after") < 0.1 * roll("error_before"));
    let known = Robot::from_toml(&fs::read_to_string(&calibrated).unwrap()).unwrap();
    let off = |parameter: RobotParameter| parameter.coordinate(&known) - parameter.coordinate(&own);
    assert!(off(RobotParameter::ImuMounting(0)).abs() < 0.4);
    assert!(off(RobotParameter::Clock).abs() < 0.002);
    let mass = RobotParameter::BodyMass;
    assert!(known.calibration().unwrap().row(mass).is_some());
    // The next calibration begins there: the robot is known before the walk is seen.
    let again = walk_of(&folder, "again.csv", &described, &["--friction", "0.75"]);
    let better = folder.path("better.toml");
    let arguments = [
        "calibrate",
        &again,
        "--healthy",
        "--json",
        "--robot",
        &calibrated,
        "--measured",
        "body_mass=1.39+-0.002",
        "-o",
        &better,
    ];
    let output = folder.program(&arguments).output().unwrap();
    let next: Value = serde_json::from_slice(&output.stdout).unwrap();
    let before = next["walks"][0]["error_before"]["validation_deg"]
        .as_f64()
        .unwrap();
    assert!(before < 0.5 * error("error_before"), "{before}");
    // The scale tells what walks do not.
    let parameters = next["parameters"].as_array().unwrap().iter();
    let mut masses = parameters.filter(|one| one["name"] == "body_mass");
    let weighed = masses.next().unwrap();
    assert_eq!(weighed["is_told"], true);
    assert!((weighed["physical"].as_f64().unwrap().exp() - 1.39).abs() < 0.004);
    assert_eq!(next["measured"][0]["deviation"], 0.002);
    // Comments of the description are kept, and the old section is replaced.
    let text = fs::read_to_string(&better).unwrap();
    assert!(text.starts_with("# Hiwonder JetHexa"));
    assert_eq!(text.matches("[calibration]").count(), 1);
}

#[test]
fn a_damaged_robot_is_not_learned_from() {
    let folder = Folder::new();
    let log = folder.path("damaged.csv");
    folder.succeeds(&["simulate", "-o", &log, "--legs-lost", "2", "--walk-s", "7"]);
    let robot = folder.path("robot.toml");
    // The damage is plain on the nominal model.
    let config = folder.write("config.toml", "variations = [{}]\n");
    let arguments = ["calibrate", &log, "--config", &config, "-o", &robot];
    let message = ["damaged.csv", "leg 2 is damaged", "expected a healthy walk"];
    folder.fails(&arguments, 1, &message);
    assert!(!fs::exists(&robot).unwrap());
}

#[test]
fn what_cannot_be_calibrated_is_said() {
    let folder = Folder::new();
    let log = folder.path("healthy.csv");
    folder.succeeds(&["simulate", "-o", &log, "--walk-s", "4"]);
    let robot = folder.path("robot.toml");
    let arguments = [
        "calibrate",
        &log,
        "--gait",
        "tripod",
        "--gait",
        "tripod",
        "-o",
        &robot,
    ];
    folder.fails(&arguments, 2, &["2 gaits for 1 logs", "one for each"]);
    let weighed = [
        "calibrate",
        &log,
        "--measured",
        "body_mass=1.4",
        "-o",
        &robot,
    ];
    folder.fails(&weighed, 2, &["--measured", "NAME=VALUE+-DEVIATION"]);
    let missing = folder.path("none.csv");
    folder.fails(&["calibrate", &missing, "-o", &robot], 2, &["none.csv"]);
    let kept = folder.write("kept.toml", "precious");
    folder.fails(&["calibrate", &log, "-o", &kept], 2, &["kept.toml"]);
    assert_eq!(fs::read_to_string(&kept).unwrap(), "precious");
    // A description whose calibration is broken names line and field.
    let (own, _) = own_robot(&folder);
    let text = own.written_into(Robot::JETHEXA_TOML).unwrap();
    for (section, expected) in [
        (
            "parameters = [{ name = \"stifness\", physical = 0 }]",
            "parameters[0].name",
        ),
        (
            "parameters = [{ name = \"clock\", physical = 0 }]\ncovariance = [[-1]]",
            "covariance",
        ),
    ] {
        let rest = if section.contains("covariance") {
            ""
        } else {
            "\ncovariance = [[1]]"
        };
        let broken =
            format!("{text}\n[calibration]\n{section}{rest}\nphysical_covariance = [[1]]\n");
        let file = folder.write("broken.toml", broken);
        let arguments = ["calibrate", &log, "--robot", &file, "-o", &robot];
        folder.fails(&arguments, 2, &["broken.toml", "line ", expected]);
    }
}
