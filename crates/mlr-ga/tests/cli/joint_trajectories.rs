//! Joint trajectories written and walked by `simulate`, through the program.

use std::fs;

use crate::program::Folder;
use mlr_model::{Gait, JointTrajectory, Motion, Robot};
use serde_json::Value;

const BAD_INPUT: i32 = 2;

/// Simulates three seconds of a walk and returns its log and its joint angles.
fn simulated(folder: &Folder, name: &str, more: &[&str]) -> (String, String) {
    let log = folder.path(&format!("{name}.csv"));
    let joints = folder.path(&format!("{name}-joints.csv"));
    let fixed = [
        "simulate", "-o", &log, "--joints", &joints, "--walk-s", "3", "--json",
    ];
    let report = folder.succeeds(&[&fixed[..], more].concat());
    let report: Value = serde_json::from_str(&report).unwrap();
    assert_eq!(report["joints"], joints);
    let text = |path| fs::read_to_string(path).unwrap();
    (text(log), text(joints))
}

#[test]
fn the_joint_angles_of_a_walk_are_those_of_the_undamaged_robot_from_its_stance_on() {
    let folder = Folder::new();
    let (_, joints) = simulated(&folder, "healthy", &[]);
    let mut lines = joints.lines();
    assert_eq!(lines.next(), Some("# repeat 101..151"));
    let columns = lines.next().unwrap();
    assert!(columns.starts_with("t_s,leg1_coxa_rad,leg1_femur_rad,leg1_tibia_rad,leg2_coxa_rad,"));
    assert_eq!(columns.split(',').count(), 1 + 18);
    assert_eq!(lines.clone().count(), 151);
    assert!(lines.next().unwrap().starts_with("0,"));
    assert!(lines.next().unwrap().starts_with("0.02,"));
    // Lost legs keep their columns.
    let (_, of_damaged) = simulated(&folder, "damaged", &["--legs-lost", "1,4"]);
    assert_eq!(of_damaged, joints);
    // The control: another robot has other columns.
    let octopod = |folder: &str, file: &str| {
        format!("{}/../../data/{folder}/{file}", env!("CARGO_MANIFEST_DIR"))
    };
    let (robot, gait) = (
        octopod("robot", "octopod.toml"),
        octopod("gait", "octopod.toml"),
    );
    let (_, of_octopod) = simulated(&folder, "octopod", &["--robot", &robot, "--gait", &gait]);
    assert!(of_octopod.contains(",leg8_tibia_rad\n"));
}

#[test]
fn a_walk_from_its_own_joint_angles_is_the_same_walk() {
    let folder = Folder::new();
    let (log, joints) = simulated(&folder, "tripod", &["--legs-lost", "3"]);
    let robot = Robot::jethexa();
    let trajectory = JointTrajectory::from_csv(&joints, &robot).unwrap();
    let rows = Gait {
        name: "rows".into(),
        period_s: 1.0,
        motion: Motion::Joints(trajectory),
    };
    let gait = folder.write("rows.toml", rows.to_toml());
    let (from_rows, joints_again) =
        simulated(&folder, "rows", &["--legs-lost", "3", "--gait", &gait]);
    // Angles in the gait's file are rounded to 1e-5 rad.
    let apart = |a: &str, b: &str| {
        let numbers = |text: &str| -> Vec<f64> {
            let fields = text.lines().flat_map(|line| line.split(','));
            fields.filter_map(|field| field.parse().ok()).collect()
        };
        let (a, b) = (numbers(a), numbers(b));
        assert_eq!(a.len(), b.len());
        a.iter()
            .zip(&b)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max)
    };
    assert!(apart(&joints, &joints_again) < 0.51e-5);
    assert!(apart(&log, &from_rows) < 2e-3);
    // The control: the tripod without the loss is another walk.
    let (healthy, _) = simulated(&folder, "healthy", &[]);
    assert!(apart(&log, &healthy) > 2e-2);
}

#[test]
fn a_lost_leg_shows_in_a_motion_that_ends() {
    let folder = Folder::new();
    let robot = Robot::jethexa();
    let tripod = JointTrajectory::commanded(&robot, &Gait::tripod(), 2.6).unwrap();
    let ending = JointTrajectory::new(0.02, tripod.rows_rad().to_vec(), None).unwrap();
    let ending = Gait {
        name: "ending".into(),
        period_s: 1.0,
        motion: Motion::Joints(ending),
    };
    let gait = folder.write("ending.toml", ending.to_toml());
    let config = folder.write(
        "quick.toml",
        "window_s = 2.5\nlost_links = \"absent\"\nvariations = [{}]\n\
         [genetic]\nislands = 1\ngenerations = 4\n",
    );
    for (legs_lost, expected) in [("", vec![]), ("3", vec![3])] {
        let name = format!("lost-{legs_lost}");
        simulated(&folder, &name, &["--gait", &gait, "--legs-lost", legs_lost]);
        let log = folder.path(&format!("{name}.csv"));
        let identify = [
            "identify", &log, "--json", "--gait", &gait, "--config", &config,
        ];
        let answer: Value = serde_json::from_str(&folder.succeeds(&identify)).unwrap();
        assert_eq!(answer["damaged_legs"], Value::from(expected), "{answer}");
    }
}

#[test]
fn half_a_minute_at_full_precision_loads() {
    let folder = Folder::new();
    let robot = Robot::jethexa();
    let tripod = JointTrajectory::commanded(&robot, &Gait::tripod(), 30.0).unwrap();
    let rows = tripod.rows_rad().iter().map(|row| format!("{row:?},\n"));
    let text = format!(
        "name = \"long\"\nperiod_s = 1.0\nrow_s = 0.02\njoints_rad = [\n{}]\n",
        rows.collect::<String>()
    );
    assert!(text.len() > 400_000, "{}", text.len());
    let gait = folder.write("long.toml", &text);
    let (log, _) = simulated(&folder, "long", &["--gait", &gait]);
    let (of_feet, _) = simulated(&folder, "feet", &[]);
    assert_eq!(log, of_feet);
}

#[test]
fn gait_files_that_make_no_sense_are_named_with_line_and_field() {
    let folder = Folder::new();
    let robot = Robot::jethexa();
    let tripod = JointTrajectory::commanded(&robot, &Gait::tripod(), 3.0).unwrap();
    let good = Gait {
        name: "rows".into(),
        period_s: 1.0,
        motion: Motion::Joints(tripod),
    };
    let good = good.to_toml();
    let row = good.lines().nth(9).unwrap();
    let (without_last, _) = row.rsplit_once(", ").unwrap();
    for (text, message_has) in [
        (
            good.replace(row, &format!("{without_last}],")),
            vec!["line 10: joints_rad[4]: 17 angles", "expected 18"],
        ),
        (
            good.replace(row, &format!("{without_last}, nan],")),
            vec!["line 10: joints_rad[4][17]: NaN"],
        ),
        (good.replace(row, ""), vec!["line 4: repeat_rows[1]: 151"]),
        (
            good.replace("[101, 151]", "[100, 151]"),
            vec!["line 2: period_s: 1", "1.02 s"],
        ),
        (good.replace("row_s", "rows_s"), vec!["line 3", "rows_s"]),
        // Every row has one joint too few: the file is right, the robot is another.
        (
            good.lines()
                .map(|line| line.replace("  [", "  [0.1, ") + "\n")
                .collect(),
            vec!["19 joint angles", "18 joints"],
        ),
    ] {
        let gait = folder.write("bad.toml", text);
        let arguments = ["simulate", "-o", "none.csv", "--gait", &gait];
        folder.fails(
            &arguments,
            BAD_INPUT,
            &[&["bad.toml"], &message_has[..]].concat(),
        );
    }
}

#[test]
fn joint_angles_are_written_into_new_files_only() {
    let folder = Folder::new();
    let log = folder.path("walk.csv");
    let mine = folder.write("mine.csv", "precious");
    let simulate = ["simulate", "-o", &log, "--walk-s", "1", "--joints"];
    let not_overwritten = ["mine.csv", "not overwritten"];
    folder.fails(
        &[&simulate[..], &[&mine]].concat(),
        BAD_INPUT,
        &not_overwritten,
    );
    assert_eq!(fs::read_to_string(&mine).unwrap(), "precious");
    folder.fails(
        &[&simulate[..], &["-"]].concat(),
        BAD_INPUT,
        &["name of a file"],
    );
    // Nothing was simulated for nothing.
    assert!(!fs::exists(&log).unwrap());
    let joints = folder.path("joints.csv");
    folder.succeeds(&[&simulate[..], &[&joints]].concat());
    assert!(fs::exists(&log).unwrap() && fs::exists(&joints).unwrap());
}
