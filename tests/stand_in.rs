//! Detection on every stand-in log, and identification on every one of a damaged or
//! healthy robot on even ground, with default settings. The truth is read by the assertions only.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::{collections::BTreeMap, fs};

use mlr_ga::{DetectionSettings, IdentifySettings, Search, detect, identify};
use mlr_golden_tests::data;
use mlr_imu::{Columns, read_log};
use mlr_model::{Gait, Robot};
use serde::Deserialize;

#[derive(Deserialize)]
struct Truth {
    morphology: Vec<Vec<u8>>,
    motion_start_s: f64,
}

impl Truth {
    fn damaged_legs(&self) -> Vec<usize> {
        (1..)
            .zip(&self.morphology)
            .filter(|(_, leg)| leg.contains(&0))
            .map(|(number, _)| number)
            .collect()
    }
}

fn truths() -> BTreeMap<String, Truth> {
    serde_json::from_str(&fs::read_to_string(data("logs/stand-in/truth.json")).unwrap()).unwrap()
}

/// The paper's detection figure: the damage of `detect-legs3-4` strikes at 19 s.
#[test]
fn notices_damage_and_nothing_else() {
    for (name, truth) in truths() {
        let log = data(&format!("logs/stand-in/{name}.csv.gz"));
        let recording = read_log(&log, &Columns::default()).unwrap();
        let detection = detect(recording, &DetectionSettings::default()).unwrap();
        let start_s = detection.motion_start_s.unwrap();
        assert!(
            (start_s - truth.motion_start_s).abs() < 0.08,
            "{name}: {start_s}"
        );
        if truth.damaged_legs().is_empty() {
            assert_eq!(detection.damage_s, None, "{name}");
            continue;
        }
        let struck_s = match name.as_str() {
            "detect-legs3-4" => 19.0,
            _ => truth.motion_start_s,
        };
        let delay_s = detection.damage_s.unwrap() - struck_s;
        let slowest_s = if name == "detect-legs3-4" { 3.5 } else { 4.0 };
        assert!((2.0..slowest_s).contains(&delay_s), "{name}: {delay_s} s");
    }
}

#[test]
fn names_the_damaged_legs() {
    let truths = truths();
    let names: Vec<_> = truths
        .keys()
        .filter(|name| {
            !name.starts_with("undeclared")
                && !name.starts_with("detect")
                && !name.ends_with("harsh")
        })
        .collect();
    assert_eq!(names.len(), 8);
    for name in names {
        let log = data(&format!("logs/stand-in/{name}.csv.gz"));
        let answer = identify(
            read_log(&log, &Columns::default()).unwrap(),
            &Robot::jethexa(),
            &Gait::tripod(),
            &IdentifySettings::default(),
            Search::Genetic { repeats: 1 },
            1,
            &(),
        )
        .unwrap();
        let truth = &truths[name];
        assert_eq!(answer.damaged_legs, truth.damaged_legs(), "{name}");
        let late_s = answer.motion_start_s - truth.motion_start_s;
        assert!(late_s.abs() < 0.08, "{name}: walk found {late_s} s late");
        assert_eq!(answer.warnings, Vec::<String>::new(), "{name}");
    }
}
