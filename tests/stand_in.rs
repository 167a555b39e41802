//! The program's main job on every stand-in log of a damaged or healthy robot on
//! even ground, with default settings. The truth is read by the assertions only.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::{collections::BTreeMap, fs};

use mlr_ga::{IdentifySettings, Search, identify};
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

#[test]
fn names_the_damaged_legs() {
    let truths: BTreeMap<String, Truth> =
        serde_json::from_str(&fs::read_to_string(data("logs/stand-in/truth.json")).unwrap())
            .unwrap();
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
