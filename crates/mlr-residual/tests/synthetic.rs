//! Effects put into made-up records are found, and none where there is none.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::f64::consts::TAU;

use mlr_residual::{
    AxisName, SelectionSettings, SensorError, SensorExplanation, SensorRecord, SensorSignals,
    explain_sensor,
};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// What a made-up sensor does.
#[derive(Clone, Copy)]
struct Sensor {
    bias_dps: f64,
    drift_dps_per_min: f64,
    scale: f64,
    delay_s: f64,
    rests: bool,
    wander_dps: f64,
    seed: u64,
}

const IDEAL: Sensor = Sensor {
    bias_dps: 0.0,
    drift_dps_per_min: 0.0,
    scale: 1.0,
    delay_s: 0.0,
    rests: false,
    wander_dps: 0.0,
    seed: 1,
};

/// The true angle: two swings of different length; with rests, it stands still for
/// three seconds in every ten.
fn angle_deg(t: f64, rests: bool) -> f64 {
    let t = if rests {
        let (cycle, within) = ((t / 10.0).floor(), t.rem_euclid(10.0));
        // Speeds up and slows down smoothly over seven seconds.
        let share = (within / 7.0).min(1.0);
        7.0 * (cycle + share - (TAU * share).sin() / TAU)
    } else {
        t
    };
    50.0 * (TAU * t / 6.3).sin() + 20.0 * (TAU * t / 1.7).sin()
}

fn record(sensor: Sensor) -> SensorRecord {
    let mut random = ChaCha8Rng::seed_from_u64(sensor.seed);
    let mut noise = |deviation: f64| {
        let sum: f64 = (0..12).map(|_| random.random::<f64>()).sum();
        deviation * (sum - 6.0)
    };
    let mut signals = SensorSignals::new(Vec::new(), Vec::new());
    let mut reference_deg = Vec::new();
    let mut t: f64 = 0.0;
    let mut wander = 0.0;
    while t < 120.0 {
        let h = 1e-4;
        let past = t - sensor.delay_s;
        let rate =
            (angle_deg(past + h, sensor.rests) - angle_deg(past - h, sensor.rests)) / (2.0 * h);
        wander += noise(sensor.wander_dps);
        let bias = sensor.bias_dps + sensor.drift_dps_per_min * t / 60.0 + wander;
        signals.times_s.push(t);
        signals
            .rate_dps
            .push(rate / sensor.scale + bias + noise(0.05));
        reference_deg.push(angle_deg(t, sensor.rests) + noise(0.03));
        t += 0.01 + noise(0.0003);
    }
    signals.axis = Some(AxisName::X);
    SensorRecord::new(signals, reference_deg).unwrap()
}

fn explained(sensor: Sensor) -> SensorExplanation {
    explain_sensor(&record(sensor), &SelectionSettings::default()).unwrap()
}

fn found_parameter(found: &SensorExplanation, kind: &str, name: &str) -> Option<f64> {
    let effect = found.effects.iter().find(|effect| effect.kind == kind)?;
    Some(effect.parameters[name])
}

fn parameter(found: &SensorExplanation, kind: &str, name: &str) -> f64 {
    found_parameter(found, kind, name)
        .unwrap_or_else(|| panic!("{kind} is not among {:?}", found.effects))
}

#[test]
fn a_good_sensor_lacks_nothing() {
    for seed in 0..8 {
        let found = explained(Sensor { seed, ..IDEAL });
        assert!(found.effects.is_empty(), "seed {seed}: {:?}", found.effects);
        assert!(!found.unexplained, "seed {seed}: {found:?}");
        assert_eq!(found.error_before, found.error_after);
    }
}

#[test]
fn a_bias_that_wanders_is_read_off_at_rest() {
    let sensor = Sensor {
        rests: true,
        wander_dps: 0.005,
        bias_dps: 0.4,
        ..IDEAL
    };
    let found = explained(sensor);
    parameter(&found, "bias_at_rest", "memory_s");
    assert!(
        found.error_after.validation_deg
            < 0.35 * {
                let settings = SelectionSettings {
                    without: vec!["bias_at_rest".into()],
                    ..SelectionSettings::default()
                };
                explain_sensor(&record(sensor), &settings)
                    .unwrap()
                    .error_after
                    .validation_deg
            }
    );
}

/// Everything that was decided, and on what.
fn decisions(found: &SensorExplanation) -> String {
    let steps: Vec<_> = found
        .effects
        .iter()
        .map(|effect| {
            let error = effect.error_deg.unwrap();
            let p_value = effect.p_value;
            (
                &effect.kind,
                &effect.parameters,
                p_value,
                error.selection_deg,
            )
        })
        .collect();
    let verdicts: Vec<_> = found.candidates.iter().map(|c| &c.verdict).collect();
    format!("{steps:?} {verdicts:?} {}", found.noise_floor_deg)
}

#[test]
fn the_test_stretch_decides_nothing() {
    let good = record(Sensor {
        bias_dps: 0.7,
        scale: 1.03,
        delay_s: 0.02,
        ..IDEAL
    });
    let explained_with = |[from_s, to_s]: [f64; 2]| {
        let reference = good.signals().times_s.iter().zip(good.angle_deg());
        let bent = reference.map(|(t, angle)| {
            let inside = (from_s..to_s).contains(t);
            angle
                + if inside {
                    5.0 * (t - from_s).sin()
                } else {
                    0.0
                }
        });
        let record = SensorRecord::new(good.signals().clone(), bent.collect()).unwrap();
        explain_sensor(&record, &SelectionSettings::default()).unwrap()
    };
    let stretches = good.stretches();
    let expected = explained_with([0.0, 0.0]);
    assert!(!expected.unexplained);
    let found = explained_with([stretches.test[0], f64::INFINITY]);
    assert_eq!(decisions(&found), decisions(&expected));
    assert!(found.error_after.validation_deg > 3.0);
    assert!(found.unexplained);
    // Control: the selection stretch decides.
    let found = explained_with(stretches.selection);
    assert_ne!(decisions(&found), decisions(&expected));
}

#[test]
fn what_no_effect_explains_is_said_to_be_unexplained() {
    // A reference that jumps by 3° every 16 s.
    let good = record(IDEAL);
    let reference = good.signals().times_s.iter().zip(good.angle_deg());
    let jumping = reference
        .map(|(t, angle)| {
            angle
                + if (t / 16.0).floor() % 2.0 == 0.0 {
                    0.0
                } else {
                    3.0
                }
        })
        .collect();
    let record = SensorRecord::new(good.signals().clone(), jumping).unwrap();
    let found = explain_sensor(&record, &SelectionSettings::default()).unwrap();
    assert!(found.unexplained, "{found:?}");
    assert!(found.residual.whiteness_p_value < 0.01);
}

#[test]
fn records_that_cannot_answer_say_why() {
    let signals = |seconds: i32| {
        let times_s: Vec<f64> = (0..seconds * 100).map(|i| f64::from(i) * 0.01).collect();
        SensorSignals::new(times_s.clone(), vec![0.0; times_s.len()])
    };
    let short = SensorRecord::new(signals(5), vec![0.0; 500]).unwrap_err();
    assert!(matches!(short, SensorError::TooShort { .. }), "{short}");
    let still = SensorRecord::new(signals(60), vec![0.0; 6000]).unwrap_err();
    assert!(matches!(still, SensorError::NoMotion { .. }), "{still}");
    let mut backwards = signals(60);
    backwards.times_s.reverse();
    let backwards = SensorRecord::new(backwards, vec![0.0; 6000]).unwrap_err();
    assert!(
        matches!(backwards, SensorError::Disordered { .. }),
        "{backwards}"
    );
    assert!(backwards.is_recordings_fault());
    let uneven = SensorRecord::new(signals(60), vec![0.0; 3]).unwrap_err();
    assert!(!uneven.is_recordings_fault(), "{uneven}");
}

/// An effect that the fit puts where it does nothing is no effect, however the errors of
/// the others fall out beside it.
#[test]
fn what_is_fitted_away_is_not_found() {
    let found = explained(Sensor {
        bias_dps: -0.1,
        scale: 1.056_692_947_699_389,
        delay_s: 0.037_925_646_371_215_61,
        seed: 974,
        ..IDEAL
    });
    let kinds: Vec<_> = found.effects.iter().map(|e| e.kind.as_str()).collect();
    assert!(!kinds.contains(&"stamp_jitter"), "{kinds:?}");
    let jitter = found.candidates.iter().find(|c| c.kind == "stamp_jitter");
    assert_eq!(
        jitter.unwrap().verdict,
        "its 95 % intervals on the fit stretch include no effect"
    );
}

/// `significance` bounds how often a forward-selection step adds what is not there; it is not
/// zero.
#[test]
fn hardly_ever_is_more_found_than_there_is() {
    // The first reading of the reference is noisy, and the rate curved between samples.
    let true_kinds = [
        "gyro_bias",
        "gyro_scale",
        "sensor_delay",
        "start_angle",
        "curved_rate",
    ];
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
    let mut too_many = Vec::new();
    let sensors = 20;
    for seed in 0..sensors {
        let found = explained(Sensor {
            bias_dps: between(-3.0, 3.0),
            scale: between(0.93, 1.07),
            delay_s: between(0.01, 0.08),
            seed,
            ..IDEAL
        });
        if found.unexplained {
            too_many.push((seed, "unexplained".into()));
        }
        let kinds = found.effects.into_iter().map(|effect| effect.kind);
        let stray = kinds.filter(|kind| !true_kinds.contains(&kind.as_str()));
        too_many.extend(stray.map(|kind| (seed, kind)));
    }
    assert!(too_many.len() as u64 <= sensors / 20, "{too_many:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, ..ProptestConfig::default() })]

    #[test]
    fn bias_scale_and_delay_are_found_together(
        bias_dps in prop_oneof![-3.0..-0.1, 0.1..3.0],
        scale in prop_oneof![0.93..0.99, 1.01..1.07],
        delay_s in 0.01..0.08,
        seed in 0_u64..1000,
    ) {
        let found = explained(Sensor { bias_dps, scale, delay_s, seed, ..IDEAL });
        prop_assert!((parameter(&found, "gyro_bias", "x_dps") - bias_dps).abs() < 0.02);
        prop_assert!((parameter(&found, "gyro_scale", "scale") - scale).abs() < 0.002);
        // To motion this slow a lag is a delay by its time constant, and may take over a
        // part of it.
        let late_s = parameter(&found, "sensor_delay", "delay_s")
            + found_parameter(&found, "sensor_lag", "time_constant_s").unwrap_or(0.0);
        prop_assert!((late_s - delay_s).abs() < 0.001, "{:?}", found.effects);
        prop_assert!(found.error_after.validation_deg < 0.5, "{:?}", found.error_after);
    }

    #[test]
    fn a_drift_of_the_bias_is_found(
        drift in prop_oneof![-1.0..-0.2, 0.2..1.0],
        seed in 0_u64..1000,
    ) {
        let found = explained(Sensor { drift_dps_per_min: drift, seed, ..IDEAL });
        prop_assert!((parameter(&found, "bias_drift", "dps_per_min") - drift).abs() < 0.03);
    }
}
