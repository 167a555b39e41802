//! Logs written by `simulate` and read by `identify`, through the program.

use crate::program::Folder;
use serde_json::Value;

/// A genetic algorithm that takes a second or two.
pub(crate) const QUICK: &str = "window_s = 3.0\nlost_links = \"absent\"\nvariations = [{}]\n[genetic]\nislands = 1\ngenerations = 4\n";

fn identified(folder: &Folder, log: &str, more: &[&str]) -> Value {
    let config = folder.write("quick.toml", QUICK);
    let mut arguments = vec!["identify", log, "--json", "--config", &config];
    arguments.extend(more);
    serde_json::from_str(&folder.succeeds(&arguments)).unwrap()
}

fn simulated(folder: &Folder, name: &str, damage: &[&str]) -> String {
    let log = folder.path(name);
    let mut arguments = vec!["simulate", "-o", &log, "--walk-s", "4"];
    arguments.extend(damage);
    arguments.push("--json");
    let report: Value = serde_json::from_str(&folder.succeeds(&arguments)).unwrap();
    assert_eq!(report["schema"], "mlr.simulation/1");
    assert_eq!(
        report["samples"], 3001,
        "two seconds of standing, four of walking"
    );
    log
}

#[test]
fn the_model_finds_its_own_damage() {
    let folder = Folder::new();
    for (name, legs, expected) in [
        ("healthy.csv", "", vec![]),
        ("three.csv.gz", "3", vec![3]),
        ("two.csv", "2", vec![2]),
    ] {
        let log = simulated(&folder, name, &["--legs-lost", legs]);
        let answer = identified(&folder, &log, &[]);
        let expected_legs: Vec<u64> = expected;
        assert_eq!(
            answer["damaged_legs"],
            Value::from(expected_legs.clone()),
            "{name}"
        );
        assert_eq!(answer["schema"], "mlr.identification/1");
        let start_s = answer["motion_start_s"].as_f64().unwrap();
        assert!((start_s - 2.0).abs() < 0.06, "{name} starts at {start_s}");
        assert!(answer["mean_error_deg"].as_f64().unwrap() < 0.7);
        for (leg, probability) in (1..).zip(answer["leg_damage_probability"].as_array().unwrap()) {
            let wrong =
                f64::from(u8::from(expected_legs.contains(&leg))) - probability.as_f64().unwrap();
            assert!(wrong.abs() < 0.1, "{name}: leg {leg}: {probability}");
        }
    }
}

#[test]
fn the_same_answer_whatever_the_number_of_threads() {
    let folder = Folder::new();
    let log = simulated(
        &folder,
        "log.csv",
        &["--morphology", "111 110 111 000 111 111"],
    );
    let answer = |threads| {
        let mut answer = identified(&folder, &log, &["--threads", threads, "--seed", "5"]);
        answer["elapsed_s"] = Value::Null;
        answer
    };
    let alone = answer("1");
    assert_eq!(alone, answer("2"));
    assert_eq!(alone, answer("8"));
}

#[test]
fn repeats_report_how_often_each_morphology_was_found() {
    let folder = Folder::new();
    let log = simulated(&folder, "log.csv", &["--legs-lost", "3"]);
    let answer = identified(&folder, &log, &["--repeats", "3"]);
    let frequencies = answer["frequencies"].as_array().unwrap();
    let runs: u64 = frequencies
        .iter()
        .map(|f| f["count"].as_u64().unwrap())
        .sum();
    assert_eq!(runs, 3);
    assert_eq!(frequencies[0]["morphology"], answer["morphology"]);
    let costs = answer["cost_per_generation"].as_array().unwrap();
    assert_eq!(
        costs.len(),
        1 + 4 + 1,
        "initial, four generations, refinement"
    );
    assert!(
        costs
            .windows(2)
            .all(|pair| pair[1].as_f64() <= pair[0].as_f64())
    );
}

#[test]
fn foreign_columns_and_units() {
    let folder = Folder::new();
    let log = simulated(&folder, "log.csv", &["--legs-lost", "3,4"]);
    let ours = std::fs::read_to_string(&log).unwrap();
    let mut foreign = String::from("stamp_ms,euler_x,euler_y,euler_z\n");
    for line in ours.lines().skip(1) {
        let numbers: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        foreign += &format!(
            "{},{},{},{}\n",
            numbers[0] * 1e3,
            numbers[1].to_degrees(),
            numbers[2].to_degrees(),
            numbers[3].to_degrees()
        );
    }
    let foreign = folder.write("foreign.csv", foreign);
    let renamed = identified(
        &folder,
        &foreign,
        &[
            "--column",
            "t=stamp_ms,ms",
            "--column",
            "roll=euler_x,deg",
            "--column",
            "pitch=euler_y,deg",
            "--column",
            "yaw=euler_z,deg",
        ],
    );
    let original = identified(&folder, &log, &[]);
    assert_eq!(renamed["morphology"], original["morphology"]);
    let cost = |answer: &Value| answer["cost_rad"].as_f64().unwrap();
    assert!((cost(&renamed) - cost(&original)).abs() < 1e-6);
}

#[test]
fn ten_minutes_of_log_are_read_and_answered() {
    let folder = Folder::new();
    let log = simulated(&folder, "log.csv", &["--legs-lost", "3,4"]);
    let mut text = std::fs::read_to_string(&log).unwrap();
    let mut last = text.lines().last().unwrap().split(',');
    let end_s: f64 = last.next().unwrap().parse().unwrap();
    let angles_rad: Vec<f64> = last.map(|angle| angle.parse().unwrap()).collect();
    for i in 1..600_000 {
        // The robot stands, and its sensor is a little noisy.
        let noise_rad = f64::from((i % 101) * 7919 % 101) * 1e-6;
        let [roll, pitch, yaw] = [0, 1, 2].map(|axis| angles_rad[axis] + noise_rad);
        let time_s = end_s + f64::from(i) * 0.001;
        text += &format!("{time_s:.3},{roll:.7},{pitch:.7},{yaw:.7}\n");
    }
    let long = folder.write("long.csv", text);
    assert_eq!(
        identified(&folder, &long, &[])["morphology"],
        identified(&folder, &log, &[])["morphology"]
    );
}

#[test]
fn the_table_is_for_people() {
    let folder = Folder::new();
    let log = simulated(&folder, "log.csv", &["--legs-lost", "3"]);
    let config = folder.write("quick.toml", QUICK);
    let table = folder.succeeds(&["identify", &log, "--config", &config]);
    assert!(
        table.contains("\ndamage        leg 3 (middle left) lost"),
        "{table}"
    );
    assert!(table.contains("\nnext best     111 "), "{table}");
}

#[test]
fn bad_time_stamps_are_repaired_and_reported() {
    let folder = Folder::new();
    let log = simulated(&folder, "log.csv", &["--legs-lost", "3"]);
    let text = std::fs::read_to_string(&log).unwrap();
    let mut lines: Vec<&str> = text.lines().collect();
    lines.insert(1000, lines[999]);
    lines.swap(1500, 1501);
    let spoilt = folder.write("spoilt.csv", lines.join("\n") + "\n");
    let config = folder.write("quick.toml", QUICK);
    let output = folder
        .program(&["identify", &spoilt, "--json", "--config", &config])
        .output()
        .unwrap();
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    let warning = answer["warnings"][0].as_str().unwrap();
    assert!(
        warning.contains("1 duplicated, 1 out of order"),
        "{warning}"
    );
    assert!(String::from_utf8(output.stderr).unwrap().contains(warning));
    assert_eq!(answer["damaged_legs"], Value::from(vec![3]));
}

#[test]
fn a_plot_shows_both_signals_and_overwrites_nothing() {
    let folder = Folder::new();
    let log = simulated(&folder, "log.csv", &["--legs-lost", "3"]);
    let plot = folder.path("roll.svg");
    identified(&folder, &log, &["--plot", &plot]);
    let svg = std::fs::read_to_string(&plot).unwrap();
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
    for label in [
        "measured",
        "simulated",
        "roll",
        "pitch",
        "yaw",
        "leg 3 lost",
    ] {
        assert!(svg.contains(label), "{label}");
    }
    let config = folder.path("quick.toml");
    folder.fails(
        &["identify", &log, "--config", &config, "--plot", &plot],
        2,
        &["roll.svg", "not overwritten"],
    );
}

#[test]
fn diverged_simulations_are_counted_and_never_win() {
    let folder = Folder::new();
    let log = simulated(&folder, "log.csv", &["--legs-lost", "3"]);
    // Links of next to no inertia, which single precision cannot simulate.
    let hollow: String = mlr_model::Robot::JETHEXA_TOML
        .lines()
        .map(|line| match line {
            line if line.starts_with("inertia") && line.contains("e-5") => {
                "inertia_kg_m2 = [1e-20, 1e-20, 1e-20]\n".into()
            }
            line => format!("{line}\n"),
        })
        .collect();
    let robot = folder.write("hollow.toml", hollow);
    let config = folder.write("quick.toml", QUICK);
    let exact = ["--search", "exact", "--robot", &robot, "--config", &config];
    let mut arguments = vec!["identify", &log, "--json"];
    arguments.extend(exact);
    let answer: Value = serde_json::from_str(&folder.succeeds(&arguments)).unwrap();
    assert_eq!(answer["evaluations"], 4096);
    assert_eq!(answer["diverged"], 4095, "all but the body without legs");
    assert_eq!(answer["damaged_legs"], Value::from(vec![1, 2, 3, 4, 5, 6]));
    assert!(answer["cost_rad"].as_f64().unwrap() > 0.0);
    assert_eq!(
        answer["alternatives"],
        Value::Array(vec![]),
        "infinite costs are none"
    );
}
