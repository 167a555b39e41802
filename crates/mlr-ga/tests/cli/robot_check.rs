//! Descriptions of robots, checked and drawn.

use std::fs;

use serde_json::Value;

use crate::program::Folder;

fn data(path: &str) -> String {
    format!("{}/../../data/{path}", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn every_shipped_robot_stands_and_walks() {
    let folder = Folder::new();
    let mut robots = 0;
    for entry in fs::read_dir(data("robot")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let gait = match name.as_str() {
            "jethexa.toml" => "tripod.toml",
            other => other,
        };
        let (robot, gait) = (
            data(&format!("robot/{name}")),
            data(&format!("gait/{gait}")),
        );
        let drawings = folder.path(&format!("{name}-drawings"));
        let arguments = [
            "robot", "check", &robot, "--gait", &gait, "--json", "--svg", &drawings,
        ];
        let report: Value = serde_json::from_str(&folder.succeeds(&arguments)).unwrap();
        assert_eq!(report["problems"], Value::Array(Vec::new()), "{name}");
        assert_eq!(report["doubts"], Value::Array(Vec::new()), "{name}");
        let of_walk = |field: &str| report["walking"][field].as_f64().unwrap();
        let told = report["commanded_speed_m_per_s"].as_f64().unwrap();
        assert!(
            (0.5 * told..1.3 * told).contains(&of_walk("speed_m_per_s")),
            "{name}: {report}"
        );
        assert!(
            of_walk("tilt_deg") < 5.0 && of_walk("torque_share") < 1.0,
            "{name}: {report}"
        );
        for drawing in ["above.svg", "side.svg", "leg1.svg", "phases.svg"] {
            let svg = fs::read_to_string(format!("{drawings}/{drawing}")).unwrap();
            assert!(
                svg.starts_with("<svg ") && svg.contains("</svg>"),
                "{drawing}"
            );
            assert!(!svg.contains("NaN"), "{drawing}");
        }
        let above = fs::read_to_string(format!("{drawings}/above.svg")).unwrap();
        assert!(above.contains("1 (front left)"), "{above}");
        robots += 1;
    }
    assert!(robots >= 3, "a hexapod, an octopod and a quadruped");
}

#[test]
fn what_cannot_be_used_is_said_with_its_reason() {
    let folder = Folder::new();
    let robot = fs::read_to_string(data("robot/quadruped.toml")).unwrap();
    let gait = data("gait/quadruped.toml");
    let refused = |from: &str, to: &str, words: &[&str]| {
        assert!(robot.contains(from), "{from}");
        let path = folder.write("robot.toml", robot.replacen(from, to, 1));
        let output = folder
            .program(&["robot", "check", &path, "--gait", &gait])
            .output()
            .unwrap();
        let table = String::from_utf8(output.stdout).unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{table}{message}");
        for word in words {
            assert!(table.contains(word), "{word:?} is not in: {table}{message}");
        }
        assert!(table.contains("cannot be used") && message.contains("Quadruped with crawl"));
    };
    refused(
        "nominal_foot_m = [0.1636, -0.1508]",
        "nominal_foot_m = [0.2636, -0.2508]",
        &[
            "the foot of leg 2 (front right)",
            "out of its reach",
            "nominal_foot_m",
        ],
    );
    refused(
        "center_of_mass_m = [0.0, 0.0, 0.02]",
        "center_of_mass_m = [0.4, 0.0, 0.02]",
        &["mm outside the feet that it stands on"],
    );
    // Another number of legs.
    let six = data("robot/jethexa.toml");
    folder
        .program(&["robot", "check", &six, "--gait", &gait])
        .assert()
        .code(1);
    let nonsense = folder.write(
        "nonsense.toml",
        robot.replacen("mass_kg = 1.2", "mass_kg = -1.2", 1),
    );
    folder.fails(
        &["robot", "check", &nonsense, "--gait", &gait],
        2,
        &["nonsense.toml", "mass_kg"],
    );
}
