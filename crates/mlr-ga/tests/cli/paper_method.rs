//! The paper's method, one morphology beside a log, and the picture of a detection, through the
//! program.

use std::fs;

use crate::program::Folder;
use serde_json::Value;

fn simulated(folder: &Folder, legs_lost: &str, walk_s: &str) -> String {
    let log = folder.path("walk.csv");
    folder.succeeds(&[
        "simulate",
        "-o",
        &log,
        "--legs-lost",
        legs_lost,
        "--walk-s",
        walk_s,
    ]);
    log
}

fn json(folder: &Folder, arguments: &[&str]) -> Value {
    serde_json::from_str(&folder.succeeds(arguments)).unwrap()
}

#[test]
fn every_run_has_110_candidates_and_the_most_frequent_result_answers() {
    let folder = Folder::new();
    let log = simulated(&folder, "3", "6");
    let identify = [
        "identify",
        &log,
        "--json",
        "--method",
        "paper",
        "--repeats",
        "2",
    ];
    let answer = json(&folder, &identify);
    assert_eq!(answer["method"], "paper");
    assert_eq!(answer["search"], "ga");
    assert_eq!(answer["evaluations"], 2 * 110);
    let runs = answer["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 2);
    for run in runs {
        let costs = run["cost_per_generation"].as_array().unwrap();
        assert_eq!(costs.len(), 1 + 20, "nothing follows the last generation");
    }
    // Its percentages are shares of the runs.
    let ended_so = |morphology: &Value| {
        let count = runs
            .iter()
            .filter(|run| run["morphology"] == *morphology)
            .count();
        count as f64 / 2.0
    };
    let probability = answer["probability"].as_f64().unwrap();
    assert!((probability - ended_so(&answer["morphology"])).abs() < 1e-9);
    for run in runs {
        assert!(ended_so(&run["morphology"]) <= probability + 1e-9);
    }
    // What the method does not ask is not answered.
    assert_eq!(answer["something_else_probability"], Value::Null);
    // The control: the default evaluates more, and asks, on the nominal model alone as well.
    let nominal = folder.write("nominal.toml", "variations = [{}]\n");
    let default = json(&folder, &["identify", &log, "--json", "--config", &nominal]);
    assert_eq!(default["method"], "mlr");
    assert!(default["evaluations"].as_u64().unwrap() > 220);
    assert!(default["something_else_probability"].is_f64());
    assert_eq!(default["damaged_legs"], Value::from(vec![3]));
}

#[test]
fn a_file_may_name_the_method_and_change_it() {
    let folder = Folder::new();
    let log = simulated(&folder, "3", "6");
    let config = folder.write(
        "paper.toml",
        "method = 'paper'\n[genetic]\npopulation = 4\ngenerations = 2\nrepeats = 2\n",
    );
    let answer = json(&folder, &["identify", &log, "--json", "--config", &config]);
    assert_eq!(answer["method"], "paper");
    assert_eq!(answer["evaluations"], 2 * (4 + 2 * 2));
}

#[test]
fn the_papers_method_has_no_atlas_and_explains_nothing() {
    let folder = Folder::new();
    let log = simulated(&folder, "3", "6");
    let search = ["identify", &log, "--method", "paper", "--search", "atlas"];
    folder.fails(&search, 2, &["expected search \"ga\" or \"exact\""]);
    let config = folder.write("paper.toml", "method = 'paper'\n");
    folder.fails(
        &["explain", &log, "--config", &config],
        2,
        &["expected \"mlr\""],
    );
}

#[test]
fn the_morphology_that_walked_costs_less_than_others() {
    let folder = Folder::new();
    let log = simulated(&folder, "3,4", "6");
    let (picture, signals) = (folder.path("compared.svg"), folder.path("compared.csv"));
    let cost = |legs: &str, more: &[&str]| {
        let mut arguments = vec!["compare", &log, "--json", "--legs-lost", legs];
        arguments.extend(more);
        let report = json(&folder, &arguments);
        assert_eq!(report["schema"], "mlr.comparison/1");
        report["cost_rad"].as_f64().unwrap()
    };
    let right = cost("3,4", &["--plot", &picture, "--signals", &signals]);
    for wrong in ["", "3", "1,4", "4,5"] {
        assert!(cost(wrong, &[]) > 3.0 * right, "{wrong}");
    }
    assert!(
        fs::read_to_string(picture)
            .unwrap()
            .contains("legs 3,4 lost")
    );
    // F again, from the signals that were written.
    let text = fs::read_to_string(signals).unwrap();
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| {
            line.split(',')
                .map(|field| field.parse().unwrap())
                .collect()
        })
        .collect();
    assert_eq!(rows.len(), 1250, "5 s at 250 Hz");
    let sum: f64 = rows
        .iter()
        .flat_map(|row| (1..4).map(|axis| (row[axis] - row[axis + 3]).abs().to_radians()))
        .sum();
    assert!((sum - right).abs() < 0.01 * right, "{sum} {right}");
}

#[test]
fn a_detection_is_drawn_with_threshold_and_flag() {
    let folder = Folder::new();
    let log = simulated(&folder, "3,4", "6");
    let picture = folder.path("detection.svg");
    let answer = json(&folder, &["detect", &log, "--json", "--plot", &picture]);
    assert_eq!(answer["flagged"], true);
    let svg = fs::read_to_string(&picture).unwrap();
    for text in [
        "damage flagged at",
        "fluctuation",
        "threshold",
        "roll",
        "yaw",
    ] {
        assert!(svg.contains(text), "{text}");
    }
    // An existing file is never overwritten.
    folder.fails(&["detect", &log, "--plot", &picture], 2, &["detection.svg"]);
    // The paper's rule forgives no lull, so that it flags later or never.
    let literal = json(&folder, &["detect", &log, "--json", "--method", "paper"]);
    let ours_s = answer["damage_s"].as_f64().unwrap();
    assert!(
        literal["damage_s"]
            .as_f64()
            .is_none_or(|literal_s| literal_s >= ours_s)
    );
}
