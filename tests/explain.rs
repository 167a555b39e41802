//! The whole loop on stand-in logs with something in them that nothing declares. The truth
//! is read by the assertions only.
//!
//! `cargo test --release -p mlr-golden-tests --test explain -- --ignored`
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use mlr_ga::{ExplainSettings, IdentifySettings, Model, explain};
use mlr_golden_tests::data;
use mlr_imu::{Columns, read_log};
use mlr_residual::walk::{Reported, TracingSettings, WalkExplanation};

/// The explanation of a log, and the truth about it.
fn explained(name: &str) -> (WalkExplanation, serde_json::Value) {
    let log = data(&format!("logs/stand-in/{name}.csv.gz"));
    let recording = read_log(&log, &Columns::default()).unwrap();
    assert!(recording.raw_beside_angles().is_some());
    let mut identify = IdentifySettings::default();
    identify.variations.truncate(1);
    let how = ExplainSettings {
        identify: &identify,
        tracing: &TracingSettings {
            most_effects: 1,
            ..TracingSettings::default()
        },
    };
    let found = explain(&recording, Model::jethexa(), how, &()).unwrap();
    let text = std::fs::read_to_string(data("logs/stand-in/truth.json")).unwrap();
    let mut truth: serde_json::Value = serde_json::from_str(&text).unwrap();
    (found.explanation, truth[name].take())
}

fn quantity(reported: &Reported) -> f64 {
    match reported {
        Reported::Quantity(value) => *value,
        other => panic!("{other:?} is no quantity"),
    }
}

#[test]
#[ignore = "identifies twice and traces once: a minute; crates/mlr-residual/tests/walk.rs traces in less"]
fn a_tilted_sensor_is_found_and_what_it_could_be_instead() {
    let (explanation, truth) = explained("undeclared-c");
    assert_eq!(truth["effect"], "imu_misalignment");
    let tilt_deg = |axis: usize| truth["plant"]["mis_deg"][axis].as_f64().unwrap();

    assert!(explanation.damaged_legs.is_empty());
    let [effect] = &explanation.effects[..] else {
        panic!("{:?}", explanation.effects);
    };
    // On a robot that hardly turns, a slope tilts the sensor as well.
    let kinds: Vec<&str> = std::iter::once(effect.kind.as_str())
        .chain(effect.rivals.iter().map(|rival| rival.kind.as_str()))
        .collect();
    assert!(kinds.contains(&"imu_misalignment"), "{kinds:?}");
    assert!(kinds.contains(&"slope"), "{kinds:?}");
    if effect.kind == "imu_misalignment" {
        for (axis, name) in ["roll_deg", "pitch_deg"].into_iter().enumerate() {
            let found_deg = quantity(&effect.parameters[name]);
            assert!(
                (found_deg - tilt_deg(axis)).abs() < 0.5,
                "{name} {found_deg}"
            );
        }
    }
    let (before, after) = (explanation.error_before, explanation.error_after);
    assert!(after.validation_deg < 0.2 * before.validation_deg);
    assert!(!explanation.unexplained, "{:?}", explanation.residual);
}

#[test]
#[ignore = "identifies twice and traces once: a minute; crates/mlr-residual/tests/walk.rs traces in less"]
fn slippery_ground_is_found_under_a_robot_that_lost_two_legs() {
    let (explanation, truth) = explained("undeclared-b");
    assert_eq!(truth["effect"], "friction");
    let mu = truth["mu"].as_f64().unwrap();

    assert_eq!(explanation.damaged_legs, [4, 5]);
    let [effect] = &explanation.effects[..] else {
        panic!("{:?}", explanation.effects);
    };
    assert_eq!(effect.kind, "friction");
    let found_mu = quantity(&effect.parameters["mu"]);
    assert!((found_mu / mu).ln().abs() < 0.5, "{found_mu}");
    let (before, after) = (
        explanation.error_calibrated.validation_deg,
        explanation.error_after.validation_deg,
    );
    assert!(after < 0.9 * before, "{before} {after}");
}
