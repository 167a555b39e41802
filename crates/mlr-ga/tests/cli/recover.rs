//! `recover` through the program: what it writes is what a controller plays and other commands take.

use std::fs;

use mlr_model::{Gait, JointTrajectory, Robot, RobotParameter};
use serde_json::Value;

use crate::program::Folder;

/// A search of a few seconds.
const QUICK: &str =
    "[recovery]\nscreen_steps = 10000\nrobots = 1\njudged_robots = 2\ngenerations = 1\n";

/// An answer that leaves open whether legs 3 and 4 are gone or only leg 3 and what is beyond the coxa of
/// leg 4.
const ANSWER: &str = r#"{"schema": "mlr.identification/1",
  "morphology": [[1,1,1],[1,1,1],[0,0,0],[0,0,0],[1,1,1],[1,1,1]], "probability": 0.6,
  "fit": {"lost_links": "locked"},
  "alternatives": [
    {"morphology": [[1,1,1],[1,1,1],[0,0,0],[1,0,0],[1,1,1],[1,1,1]], "probability": 0.4}]}"#;

#[test]
fn a_gait_is_written_for_an_answer_and_walks_in_the_model() {
    let folder = Folder::new();
    let config = folder.write("quick.toml", QUICK);
    let answer = folder.write("answer.json", ANSWER);
    let (gait, joints) = (folder.path("gait.toml"), folder.path("joints.csv"));
    let arguments = [
        "recover", &answer, "--config", &config, "-o", &gait, "--joints", &joints, "--json",
    ];
    let report: Value = serde_json::from_str(&folder.succeeds(&arguments)).unwrap();
    assert_eq!(report["schema"], "mlr.recovery/1");
    assert_eq!(report["damaged_legs"], serde_json::json!([3, 4]));
    assert_eq!(report["folded_legs"], serde_json::json!([3, 4]));
    assert_eq!(
        (&report["cases"], &report["robots"]),
        (&2.into(), &2.into())
    );
    assert_eq!(report["lost_links"], "locked");
    assert_eq!(report["statically_stable"], true);
    let of = |outlook: &str, key: &str| report[outlook][key].as_f64().unwrap();
    assert!(of("after", "fluctuation_deg") < of("before", "fluctuation_deg"));
    assert!(of("after", "calm_probability") > of("before", "calm_probability"));
    for key in [
        "speed_m_per_s",
        "drift_deg_per_m",
        "torque_share",
        "saturated",
    ] {
        assert!(of("before", key).is_finite() && of("after", key).is_finite());
    }
    assert_eq!(report["better_than_nominal"], true);

    // Both files hold the same motion: from the nominal stance into a cycle.
    let robot = Robot::jethexa();
    let text = fs::read_to_string(&joints).unwrap();
    assert!(text.starts_with("# repeat "));
    let played = JointTrajectory::from_csv(&text, &robot).unwrap();
    let read = Gait::from_toml(&fs::read_to_string(&gait).unwrap()).unwrap();
    let cycle_s = played.repeat_rows().unwrap().len() as f64 * played.row_s();
    assert!((read.cycle_s().unwrap() - cycle_s).abs() < 1e-9);
    let stance = JointTrajectory::commanded(&robot, &Gait::tripod(), 1.0).unwrap();
    assert_eq!(played.rows_rad()[0], stance.rows_rad()[0]);

    // The gait is one that other commands take, and the damage is no longer seen.
    let log = folder.path("walk.csv");
    let simulate = [
        "simulate",
        "--legs-lost",
        "3,4",
        "--gait",
        &gait,
        "--walk-s",
        "15",
        "-o",
        &log,
    ];
    folder.succeeds(&simulate);
    let detect = folder.succeeds(&["detect", &log, "--json"]);
    let detected: Value = serde_json::from_str(&detect).unwrap();
    assert_eq!(detected["flagged"], false, "{detected}");
    // What is there is not overwritten.
    folder.fails(&arguments, 2, &["gait.toml"]);
}

#[test]
fn what_is_asked_for_must_make_sense() {
    let folder = Folder::new();
    let gait = folder.path("gait.toml");
    let fails = |more: &[&str], message: &[&str]| {
        let mut arguments = vec!["recover", "-o", &gait];
        arguments.extend(more);
        folder.fails(&arguments, 2, message);
    };
    fails(&[], &["--legs-lost"]);
    fails(&["--legs-lost", "7"], &["\"7\" is not a leg"]);
    fails(&["--weak-leg", "3"], &["--weak-leg 3", "as in 3:0.3"]);
    fails(&["--weak-leg", "9:0.3"], &["leg: 9", "1 to 6"]);
    fails(
        &["--stuck-joint", "3:2"],
        &["--stuck-joint 3:2", "as in 3:2:0.9"],
    );
    fails(&["--legs-lost", "1,2,3,4,5"], &["1 of the robot's legs"]);
    let config = folder.write("bad.toml", "[recovery]\nrobots = 0\n");
    let of_config = ["--legs-lost", "3", "--config", &config];
    fails(&of_config, &["bad.toml", "line 2: recovery.robots: 0"]);
    let strange = folder.write("strange.json", "{\"schema\": 1}");
    fails(&[&strange], &["strange.json", "identify or explain"]);
    let log = folder.write("walk.csv", "t_s\n");
    fails(&[&log, "--legs-lost", "3"], &["--legs-lost"]);
    assert!(!fs::exists(&gait).unwrap());
}

/// The file of a gait for a robot without leg 3, and what was printed of it.
fn found_without_leg_3(folder: &Folder) -> (String, String) {
    let config = folder.write("quick.toml", QUICK);
    let gait = folder.path("gait.toml");
    let arguments = [
        "recover",
        "--legs-lost",
        "3",
        "--config",
        &config,
        "-o",
        &gait,
        "--json",
    ];
    let printed = folder.succeeds(&arguments);
    (gait, printed)
}

/// A robot whose joint zeros nobody knows walks with the gait in a circle, and straight once the gait
/// is steered by its own log.
#[test]
fn a_gait_is_steered_by_how_the_robot_turned() {
    let folder = Folder::new();
    let (mut gait, found) = found_without_leg_3(&folder);
    let mut report = folder.write("recovery.json", &found);
    let turned = [(0, 0.03), (3, -0.03)];
    let robot = turned
        .into_iter()
        .fold(Robot::jethexa(), |robot, (leg, off_rad)| {
            robot.with_added(RobotParameter::JointZero { leg, joint: 1 }, off_rad)
        });
    let robot = folder.write(
        "robot.toml",
        robot.written_into(Robot::JETHEXA_TOML).unwrap(),
    );
    let mut turned_deg = Vec::new();
    for time in 1..=2 {
        let log = folder.path(&format!("walk-{time}.csv"));
        let simulate = [
            "simulate",
            "--legs-lost",
            "3",
            "--robot",
            &robot,
            "--gait",
            &gait,
            "--walk-s",
            "20",
            "-o",
            &log,
        ];
        folder.succeeds(&simulate);
        let steered = folder.path(&format!("steered-{time}.toml"));
        let joints = folder.path(&format!("steered-{time}.csv"));
        let arguments = [
            "steer", &report, &log, "-o", &steered, "--joints", &joints, "--json",
        ];
        let text = folder.succeeds(&arguments);
        let answer: Value = serde_json::from_str(&text).unwrap();
        let number = |key: &str| answer[key].as_f64().unwrap();
        assert_eq!(answer["schema"], "mlr.steering/1");
        assert!(number("cycles") >= 3.0, "{answer}");
        let steered_by = number("steering_before_deg") - number("steering_deg");
        assert!((steered_by - number("turned_deg")).abs() < 1e-9);
        turned_deg.push(number("turned_deg"));
        let played =
            JointTrajectory::from_csv(&fs::read_to_string(&joints).unwrap(), &Robot::jethexa());
        assert!(played.unwrap().repeat_rows().is_some());
        // The next log is of the steered gait, which can be steered again.
        (gait, report) = (
            steered,
            folder.write(&format!("steering-{time}.json"), &text),
        );
    }
    let [before, after] = turned_deg[..] else {
        panic!("{turned_deg:?}");
    };
    assert!(before.abs() > 0.2, "{turned_deg:?}");
    assert!(after.abs() < 0.3 * before.abs(), "{turned_deg:?}");
}

#[test]
fn what_a_gait_cannot_be_steered_by_is_refused() {
    let folder = Folder::new();
    let (gait, found) = found_without_leg_3(&folder);
    let report = folder.write("recovery.json", &found);
    let log = folder.path("short.csv");
    let short = [
        "simulate",
        "--legs-lost",
        "3",
        "--gait",
        &gait,
        "--walk-s",
        "5",
        "-o",
        &log,
    ];
    folder.succeeds(&short);
    let steered = folder.path("steered.toml");
    let fails = |report: &str, status: i32, message: &[&str]| {
        folder.fails(&["steer", report, &log, "-o", &steered], status, message);
    };
    // The way into the gait takes longer.
    fails(&report, 1, &["short.csv", "too short", "one whole cycle"]);
    let strange = folder.write("strange.json", r#"{"schema": "mlr.probe/1"}"#);
    fails(&strange, 2, &["strange.json", "mlr.recovery/1"]);
    let longer = found.replacen("\"duty_factor\":", "\"duty_factor\":1", 1);
    let longer = folder.write("longer.json", longer);
    fails(&longer, 2, &["longer.json", "duty_factor", "0 to 1"]);
    let other = found.replacen("[[1,1,1],", "[", 1);
    let other = folder.write("other.json", other);
    fails(&other, 2, &["other.json", "Hiwonder"]);
    assert!(!fs::exists(&steered).unwrap());
}
