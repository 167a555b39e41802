//! Detection on every stand-in log, and identification on every one of a damaged or
//! healthy robot on even ground, with default settings. The truth is read by the assertions only.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::{collections::BTreeMap, fs};

use mlr_filter::OrientationSeries;
use mlr_ga::{DetectionSettings, Identification, IdentifySettings, Model, detect, identify};
use mlr_golden_tests::data;
use mlr_imu::{Columns, Recording, read_log};
use mlr_model::Morphology;
use serde::Deserialize;

#[derive(Deserialize)]
struct Truth {
    morphology: Morphology,
    motion_start_s: f64,
}

impl Truth {
    fn damaged_legs(&self) -> Vec<usize> {
        self.morphology.damaged_legs()
    }
}

fn truths() -> BTreeMap<String, Truth> {
    serde_json::from_str(&fs::read_to_string(data("logs/stand-in/truth.json")).unwrap()).unwrap()
}

/// Looks for the orientation under names that no log has.
fn only_raw_columns() -> Columns {
    let mut columns = Columns::default();
    for axis in ["roll", "pitch", "yaw"] {
        columns.rename(&format!("{axis}=not_there")).unwrap();
    }
    columns
}

/// How the leading candidates are weighed.
#[derive(Clone, Copy, PartialEq)]
enum Models {
    /// As by default: the nominal model and its variations.
    All,
    /// The nominal model only, which takes half the time and is enough on even ground.
    Nominal,
}

fn identified(recording: &Recording, models: Models) -> Identification {
    let mut settings = IdentifySettings::default();
    if models == Models::Nominal {
        settings.variations.truncate(1);
    }
    identify(recording, Model::jethexa(), &settings, &()).unwrap()
}

/// The paper's detection figure: the damage of `detect-legs3-4` strikes at 19 s.
#[test]
fn notices_damage_and_nothing_else() {
    for (name, truth) in truths() {
        let log = data(&format!("logs/stand-in/{name}.csv.gz"));
        let recording = read_log(&log, &Columns::default()).unwrap();
        let detection = detect(&recording, &DetectionSettings::default()).unwrap();
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
    let nominal = [
        "healthy",
        "leg3-lost",
        "leg5-lost",
        "legs1-4-lost",
        "legs2-3-lost",
        "legs3-4-lost",
    ];
    assert_named(&nominal, Models::Nominal);
}

#[test]
#[ignore = "takes a minute: cargo test --release -- --ignored"]
fn names_the_damaged_legs_of_robots_that_need_every_model() {
    assert_named(&["leg2-lost", "legs4-5-lost", "legs1-4-harsh"], Models::All);
}

fn assert_named(names: &[&str], models: Models) {
    let truths = truths();
    for name in names {
        let log = data(&format!("logs/stand-in/{name}.csv.gz"));
        let answer = identified(&read_log(&log, &Columns::default()).unwrap(), models);
        let truth = &truths[*name];
        assert_eq!(answer.damaged_legs, truth.damaged_legs(), "{name}");
        let listed = &answer.indistinguishable;
        let covered = answer.morphology == truth.morphology || listed.contains(&truth.morphology);
        assert!(covered && listed.len() <= 12, "{name}: {listed:?}");
        let late_s = answer.motion_start_s.unwrap() - truth.motion_start_s;
        assert!(late_s.abs() < 0.08, "{name}: walk found {late_s} s late");
        assert_eq!(answer.warnings, Vec::<String>::new(), "{name}");
    }
}

/// Damage strikes a healthy robot at 19 s of the log and is flagged at 21 s.
#[test]
fn names_the_legs_lost_in_mid_walk() {
    let log = data("logs/stand-in/detect-legs3-4.csv.gz");
    let recording = read_log(&log, &Columns::default()).unwrap();
    let answer = identified(&recording, Models::Nominal);
    assert_eq!(answer.damaged_legs, [3, 4]);
    assert!((21.0..22.5).contains(&answer.window_start_s));
}

/// The log begins while the damaged robot walks: the phase of its gait is fitted.
#[test]
fn names_the_lost_legs_in_a_log_cut_from_mid_walk() {
    let log = data("logs/stand-in/legs2-3-lost.csv.gz");
    let whole = read_log(&log, &Columns::default()).unwrap().orientation;
    let from = whole.times_s().partition_point(|&t| t < 5.37);
    let cut = OrientationSeries::new(
        whole.times_s()[from..].to_vec(),
        whole
            .angles_rad()
            .as_ref()
            .map(|_, samples| samples[from..].to_vec()),
    )
    .unwrap();
    let answer = identified(&cut.into(), Models::Nominal);
    assert_eq!(answer.damaged_legs, [2, 3]);
    assert_eq!(answer.motion_start_s, None);
    assert!(answer.warnings[0].contains("phase of the gait"));
}

/// Without the orientation that the plant's own filter wrote into the log, raw
/// samples of accelerometer and gyroscope give nearly the same.
#[test]
fn raw_samples_are_fused_into_the_orientation_that_was_logged() {
    let only_raw = only_raw_columns();
    for (name, truth) in truths() {
        let log = data(&format!("logs/stand-in/{name}.csv.gz"));
        let logged = read_log(&log, &Columns::default()).unwrap().orientation;
        let fused = read_log(&log, &only_raw).unwrap().orientation;
        let walking = logged
            .times_s()
            .partition_point(|&t| t < truth.motion_start_s);
        // The logged orientation comes from another filter, with an error of its own.
        let apart_deg = |ours: &[f64], theirs: &[f64]| {
            let offset = ours[walking] - theirs[walking];
            let pairs = ours[walking..].iter().zip(&theirs[walking..]);
            let total: f64 = pairs.map(|(a, b)| (a - b - offset).abs()).sum();
            (total / (ours.len() - walking) as f64).to_degrees()
        };
        let (ours, theirs) = (fused.angles_rad(), logged.angles_rad());
        let roll = apart_deg(&ours.roll, &theirs.roll);
        let pitch = apart_deg(&ours.pitch, &theirs.pitch);
        let yaw = apart_deg(&ours.yaw, &theirs.yaw);
        assert!(
            roll < 0.6 && pitch < 1.5 && yaw < 2.0,
            "{name}: {roll} {pitch} {yaw}"
        );
    }
}

#[test]
fn raw_samples_name_the_damaged_legs() {
    let only_raw = only_raw_columns();
    let log = data("logs/stand-in/legs3-4-lost.csv.gz");
    let answer = identified(&read_log(&log, &only_raw).unwrap(), Models::Nominal);
    assert_eq!(answer.damaged_legs, [3, 4]);
}
