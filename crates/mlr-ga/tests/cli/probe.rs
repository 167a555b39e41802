//! `probe --calibrate` through the program: what it writes is what other commands take.

use std::fs;

use crate::program::Folder;
use mlr_model::{Gait, JointTrajectory, Motion, Robot};
use serde_json::{Value, json};

#[test]
fn a_motion_is_written_as_gait_and_as_joints_and_calibrates_a_robot() {
    let folder = Folder::new();
    let (motion, joints) = (
        folder.path("calibration.toml"),
        folder.path("calibration.csv"),
    );
    let arguments = [
        "probe",
        "--calibrate",
        "-o",
        &motion,
        "--joints",
        &joints,
        "--max-s",
        "9",
        // Few of the walks that fold legs keep so tight a bound: less has to be tried.
        "--max-tilt-deg",
        "9",
        "--robots",
        "4",
        "--json",
    ];
    let report: Value = serde_json::from_str(&folder.succeeds(&arguments)).unwrap();
    assert_eq!(report["schema"], "mlr.probe/1");
    assert!(report["duration_s"].as_f64().unwrap() <= 9.0);
    assert_eq!(
        report["segments"][0]["folded_legs"],
        Value::Array(Vec::new())
    );
    let nats = |key: &str| report[key].as_f64().unwrap();
    assert!(nats("motion_gain_nats") > nats("walk_gain_nats"));
    let gait = Gait::from_toml(&fs::read_to_string(&motion).unwrap()).unwrap();
    let text = fs::read_to_string(&joints).unwrap();
    let played = JointTrajectory::from_csv(&text, &Robot::jethexa()).unwrap();
    let Motion::Joints(commanded) = &gait.motion else {
        panic!("{gait:?}");
    };
    assert_eq!(commanded.rows_rad().len(), played.rows_rad().len());
    // A file of somebody else's stays as it is.
    let others = folder.write("others.toml", "mine");
    folder.fails(
        &["probe", "--calibrate", "-o", &others],
        2,
        &["others.toml"],
    );
    assert_eq!(fs::read_to_string(&others).unwrap(), "mine");
    // A robot that made the motion is calibrated by it.
    let log = folder.path("motion.csv");
    folder.succeeds(&["simulate", "-o", &log, "--gait", &motion, "--walk-s", "9"]);
    let robot = folder.path("robot.toml");
    let calibrate = [
        "calibrate",
        &log,
        "--gait",
        &motion,
        "--healthy",
        "--json",
        "-o",
        &robot,
    ];
    let output = folder.program(&calibrate).output().unwrap();
    assert!(output.status.success());
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["walks"][0]["gait"], "calibration");
    assert!(Robot::from_toml(&fs::read_to_string(&robot).unwrap()).is_ok());
}

#[test]
fn what_is_asked_for_must_make_sense() {
    let folder = Folder::new();
    let motion = folder.path("calibration.toml");
    let fails = |more: &[&str], message: &[&str]| {
        let mut arguments = vec!["probe", "-o", &motion];
        arguments.extend(more);
        folder.fails(&arguments, 2, message);
    };
    fails(&[], &["--calibrate"]);
    fails(&["--calibrate", "walk.csv"], &["one of the two"]);
    fails(&["--calibrate", "--max-s", "200"], &["--max-s", "200"]);
    fails(
        &["--calibrate", "--max-tilt-deg", "-3"],
        &["--max-tilt-deg", "-3"],
    );
    fails(&["--calibrate", "--robots", "0"], &["--robots", "0"]);
    fails(&["walk.csv", "--robots", "4"], &["--calibrate"]);
    fails(&["walk.csv", "--ask", "payload"], &["--explanation"]);
    // A bias of the gyroscope is the same in every motion.
    fails(
        &["--explanation", "walk.json", "--ask", "payload,gyro_bias"],
        &["gyro_bias", "external_force"],
    );
    assert!(!fs::exists(&motion).unwrap());
}

/// Roll and pitch of a walk straight on are the same with a slope and with a tilted sensor; of a robot that
/// turns they are not. `explain` takes what the first log said into account.
#[test]
fn a_slope_is_told_from_a_tilted_sensor_by_a_turn() {
    let folder = Folder::new();
    let whole = [[1; 3]; 6];
    let hypothesis = |kind: &str, parameters: Value| {
        json!({"morphology": whole, "locked_links": false, "unknown": false, "probability": 0.5,
               "effects": [{"kind": kind, "parameters": parameters}]})
    };
    let slope = hypothesis("slope", json!({"angle_deg": 3.6, "uphill_deg": 139.0}));
    let tilt = hypothesis(
        "imu_misalignment",
        json!({"roll_deg": 2.4, "pitch_deg": 2.7}),
    );
    let answer =
        json!({"schema": "mlr.explanation/1", "morphology": whole, "alternatives": [slope, tilt]});
    let answer = folder.write("explanation.json", answer.to_string());
    let motion = folder.path("probe.toml");
    let arguments = [
        "probe",
        "--explanation",
        &answer,
        "-o",
        &motion,
        "--max-s",
        "7.5",
        "--json",
    ];
    let report: Value = serde_json::from_str(&folder.succeeds(&arguments)).unwrap();
    let number = |key: &str| report[key].as_f64().unwrap();
    assert!((number("entropy_before_nats") - 2.0_f64.ln()).abs() < 1e-9);
    assert!(number("entropy_after_nats") < 0.1, "{report}");
    let segments = report["segments"].as_array().unwrap();
    assert!(segments.iter().any(|one| one["kind"] == "turn"), "{report}");
    assert_eq!(report["open"][0]["effects"][0]["kind"], "slope");
    // An identification knows of no effects.
    let other = folder.write(
        "identification.json",
        json!({"schema": "mlr.identification/1", "morphology": whole}).to_string(),
    );
    let again = folder.path("again.toml");
    for command in [
        &["probe", "--explanation", &other, "-o", &again][..],
        &["explain", "walk.csv", "--after", &other],
    ] {
        folder.fails(
            command,
            2,
            &["identification.json", "expected one of explain"],
        );
    }
    assert!(!fs::exists(&again).unwrap());
}

/// The front right leg is lost, its links gone by how the robot falls: the end of its femur, if that
/// is left, reaches the ground when it presses.
#[test]
fn a_motion_that_tells_lost_links_apart_ends_and_is_expected_to_tell_more() {
    let folder = Folder::new();
    let log = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../data/logs/stand-in/leg2-lost.csv.gz"
    );
    let (motion, joints) = (folder.path("probe.toml"), folder.path("probe.csv"));
    let arguments = [
        "probe", log, "-o", &motion, "--joints", &joints, "--max-s", "9", "--json",
    ];
    let report: Value = serde_json::from_str(&folder.succeeds(&arguments)).unwrap();
    assert_eq!(report["schema"], "mlr.diagnosis/1");
    let number = |key: &str| report[key].as_f64().unwrap();
    let [before, after] = ["entropy_before_nats", "entropy_after_nats"].map(number);
    assert!(after < 0.6 * before, "{before} {after}");
    assert_eq!(report["sure"], false);
    let segments = report["segments"].as_array().unwrap();
    assert_eq!(segments[0]["kind"], "nod");
    let presses = segments.iter().filter(|segment| segment["kind"] == "press");
    assert!(presses.clone().count() > 0 && presses.clone().all(|press| press["leg"] == 2));
    assert!(number("duration_s") <= 9.0);
    let gait = Gait::from_toml(&fs::read_to_string(&motion).unwrap()).unwrap();
    let text = fs::read_to_string(&joints).unwrap();
    let played = JointTrajectory::from_csv(&text, &Robot::jethexa()).unwrap();
    let rows = played.rows_rad();
    assert!(gait.duration_s().is_some() && played.repeat_rows().is_none());
    // From the stance to the stance.
    let mut ends = rows[0].iter().zip(&rows[rows.len() - 1]);
    assert!(ends.all(|(first, last)| (first - last).abs() < 1e-4));
}
