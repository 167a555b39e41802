//! `export` and `import` through the program: robots for other programs, and from them.

use std::fs;

use mlr_model::Robot;
use serde_json::{Value, json};

use crate::{program::Folder, round_trip::QUICK};

const DOG: &str = "../mlr-exchange/tests/data/dog.urdf";
const LEGS_3_4: &str = "[[1,1,1],[1,1,1],[0,0,0],[0,0,0],[1,1,1],[1,1,1]]";

#[test]
fn a_robot_is_written_to_stdout_or_into_a_file() {
    let folder = Folder::new();
    let json = folder.succeeds(&["export", "--format", "json", "--legs-lost", "3,4"]);
    let robot: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(robot["schema"], "mlr.robot/1");
    assert_eq!(robot["legs"][2]["links"], json!([]));
    assert!((robot["mass_kg"].as_f64().unwrap() - 2.18324).abs() < 1e-9);
    // What a format cannot hold goes to stderr, so that stdout is the file.
    let on_stdout = folder.program(&["export", "--format", "urdf", "--legs-lost", "3,4"]);
    let on_stdout = { on_stdout }.output().unwrap();
    assert!(on_stdout.status.success());
    assert!(
        String::from_utf8(on_stdout.stderr)
            .unwrap()
            .contains("left out: friction")
    );
    let file = folder.path("robot.urdf");
    let arguments = [
        "export",
        "--format",
        "urdf",
        "--legs-lost",
        "3,4",
        "-o",
        &file,
        "--json",
    ];
    let report: Value = serde_json::from_str(&folder.succeeds(&arguments)).unwrap();
    assert_eq!(report["schema"], "mlr.export/1");
    assert_eq!(report["joints"], 12);
    assert_eq!(report["left_out"].as_array().unwrap().len(), 2);
    let text = fs::read_to_string(&file).unwrap();
    assert_eq!(text.as_bytes(), on_stdout.stdout);
    assert_eq!(text.matches("type=\"revolute\"").count(), 12);
    folder.fails(&arguments, 2, &["robot.urdf", "exists"]);
}

#[test]
fn an_answer_is_a_robot() {
    let folder = Folder::new();
    let export = |answer: &str| {
        let answer = folder.write("answer.json", answer);
        let text = folder.succeeds(&["export", "--format", "json", "--answer", &answer]);
        serde_json::from_str::<Value>(&text).unwrap()
    };
    let found = export(&format!(
        r#"{{"schema":"mlr.explanation/1","morphology":{LEGS_3_4},"effects":[
            {{"kind":"payload","parameters":{{"mass_kg":0.4,"x_m":0.02,"y_m":-0.01}}}},
            {{"kind":"weak_leg","parameters":{{"leg":2,"gain":0.4}}}}]}}"#
    ));
    assert!((found["mass_kg"].as_f64().unwrap() - 2.58324).abs() < 1e-9);
    assert_eq!(found["legs"][1]["servo"]["stiffness_nm_per_rad"], 12.0);
    assert_eq!(found["legs"][0]["servo"]["stiffness_nm_per_rad"], 30.0);
    // The control: the same links without what else is wrong.
    let plain = folder.succeeds(&["export", "--format", "json", "--legs-lost", "3,4"]);
    let plain: Value = serde_json::from_str(&plain).unwrap();
    assert_eq!(plain["legs"][1]["servo"]["stiffness_nm_per_rad"], 30.0);
    // What the sensor has is none of the robot's, and said so.
    let answer = folder.write(
        "answer.json",
        format!(
            r#"{{"schema":"mlr.explanation/1","morphology":{LEGS_3_4},"unexplained":true,"effects":[
            {{"kind":"gyro_bias","parameters":{{"x_dps":1.0}}}}]}}"#
        ),
    );
    let file = folder.path("robot.xml");
    let arguments = [
        "export", "--format", "mjcf", "--answer", &answer, "-o", &file,
    ];
    let output = folder.program(&arguments).output().unwrap();
    let (told, table) = (
        String::from_utf8(output.stderr).unwrap(),
        String::from_utf8(output.stdout).unwrap(),
    );
    assert!(
        output.status.success() && told.contains("does not explain"),
        "{told}"
    );
    assert!(
        table.contains("gyro_bias") && table.contains("legs 3,4 lost"),
        "{table}"
    );
}

/// From a log to the robot that recorded it.
#[test]
fn what_identify_finds_is_what_export_takes() {
    let folder = Folder::new();
    let log = folder.path("walk.csv");
    let simulate = [
        "simulate",
        "--legs-lost",
        "3,4",
        "-o",
        &log,
        "--walk-s",
        "6",
    ];
    folder.succeeds(&simulate);
    let config = folder.write("quick.toml", QUICK);
    let answer = folder.succeeds(&["identify", &log, "--json", "--config", &config]);
    let found: Value = serde_json::from_str(&answer).unwrap();
    let answer = folder.write("answer.json", answer);
    let robot = folder.succeeds(&["export", "--format", "json", "--answer", &answer]);
    let robot: Value = serde_json::from_str(&robot).unwrap();
    assert_eq!(robot["morphology"], found["morphology"]);
    assert_eq!(robot["lost_links"], found["fit"]["lost_links"]);
}

#[test]
fn wrong_exports_say_what_was_expected() {
    let folder = Folder::new();
    let no_json = folder.write("answer.json", "{");
    let other = folder.write("other.json", r#"{"schema":"mlr.detection/1"}"#);
    for (arguments, told) in [
        (vec!["export"], "--format"),
        (
            vec!["export", "--format", "sdf"],
            "possible values: urdf, mjcf, json",
        ),
        (
            vec!["export", "--format", "urdf", "--legs-lost", "7"],
            "1 to 6",
        ),
        (vec!["export", "--format", "urdf", "--json"], "--output"),
        (
            vec!["export", "--format", "urdf", "--answer", &no_json],
            "answer.json",
        ),
        (
            vec!["export", "--format", "urdf", "--answer", &other],
            "mlr.identification/1",
        ),
        (
            vec![
                "export",
                "--format",
                "urdf",
                "--answer",
                &other,
                "--legs-lost",
                "1",
            ],
            "--legs-lost",
        ),
        (
            vec!["export", "--format", "urdf", "-o", "-"],
            "no -o for stdout",
        ),
        (
            vec![
                "export",
                "--format",
                "mjcf",
                "--robot",
                "../../data/robot/octopod.toml",
            ],
            "octopod.toml",
        ),
    ] {
        folder.fails(&arguments, 2, &[told]);
    }
    // Only the MJCF's stance needs a gait.
    let octopod = [
        "export",
        "--format",
        "json",
        "--robot",
        "../../data/robot/octopod.toml",
    ];
    folder.succeeds(&octopod);
}

#[test]
fn a_robot_makes_the_round_trip() {
    let folder = Folder::new();
    let (urdf, back) = (folder.path("robot.urdf"), folder.path("robot.toml"));
    folder.succeeds(&["export", "--format", "urdf", "-o", &urdf]);
    let table = folder.succeeds(&["import", &urdf, "-o", &back]);
    assert!(table.contains("within 0.00 mm"), "{table}");
    let read = Robot::from_toml(&fs::read_to_string(&back).unwrap()).unwrap();
    let apart = |robot: &Robot| {
        let legs = robot.legs().iter().zip(Robot::jethexa().legs().to_vec());
        legs.map(|(a, b)| (a.hip_m - b.hip_m).norm() + (a.hip_yaw_rad - b.hip_yaw_rad).abs())
            .sum::<f64>()
    };
    assert!(apart(&read) < 1e-6);
    assert_eq!(read.servo(), Robot::jethexa().servo());
    // The robot that was read walks as the one that was written.
    let walk = |robot: &[&str], name: &str| {
        let log = folder.path(name);
        let arguments = ["simulate", "-o", &log, "--walk-s", "2", "--legs-lost", "3"];
        folder.succeeds(&[&arguments, robot].concat());
        let text = fs::read_to_string(&log).unwrap();
        let last = text
            .lines()
            .last()
            .unwrap()
            .split(',')
            .map(|one| one.parse().unwrap());
        last.collect::<Vec<f64>>()
    };
    let (there, here) = (
        walk(&["--robot", &back], "there.csv"),
        walk(&[], "here.csv"),
    );
    let most = there
        .iter()
        .zip(&here)
        .fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
    assert!(most < 1e-3, "{there:?} {here:?}");
}

#[test]
fn robots_of_others_are_read_and_what_was_left_out_is_said() {
    let folder = Folder::new();
    let file = folder.path("dog.toml");
    let arguments = [
        "import",
        DOG,
        "-o",
        &file,
        "--fixed",
        "tail_joint",
        "--json",
    ];
    let output = folder.program(&arguments).output().unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{told}");
    assert!(
        told.contains("left out: ") && told.contains("assumed: "),
        "{told}"
    );
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["schema"], "mlr.import/1");
    assert_eq!(report["joints"].as_array().unwrap().len(), 12);
    assert_eq!(report["joints"][0]["urdf_joint"], "FL_hip_joint");
    for field in ["left_out", "assumed"] {
        let said = report[field].as_array().unwrap();
        assert!(
            said.iter()
                .all(|what| told.contains(what.as_str().unwrap()))
        );
    }
    let robot = Robot::from_toml(&fs::read_to_string(&file).unwrap()).unwrap();
    assert_eq!(robot.legs().len(), 4);
    // A joint that is none of the file's, and the tail that is no leg.
    let other = folder.path("other.toml");
    folder.fails(
        &["import", DOG, "-o", &other, "--fixed", "tails"],
        2,
        &["dog.urdf", "no joint \"tails\""],
    );
    folder.fails(
        &["import", DOG, "-o", &other],
        2,
        &["dog.urdf", "line 24", "tail_joint"],
    );
    assert!(fs::metadata(&other).is_err(), "nothing is left behind");
}

#[test]
fn hostile_urdfs_end_with_status_2() {
    let folder = Folder::new();
    let output = folder.path("robot.toml");
    let deep = "<a>".repeat(100_000);
    for (content, told) in [
        (String::new(), "robot.urdf"),
        (format!("<robot>{deep}"), "line 1"),
        (
            "<robot name=\"r\"><link name=\"a\"/><link name=\"b\"/></robot>".into(),
            "hangs on nothing",
        ),
        ("x".repeat(11_000_000), "10000 kB"),
    ] {
        let urdf = folder.write("robot.urdf", content);
        folder.fails(&["import", &urdf, "-o", &output], 2, &["robot.urdf", told]);
    }
    folder.fails(
        &["import", &folder.path("none.urdf"), "-o", &output],
        2,
        &["none.urdf"],
    );
}
