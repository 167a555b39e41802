//! When things happen.

use mlr_model::{JointTrajectory, Motion};

use super::*;

/// How much later than `before` the roll of `after` has the same course over a second of the walk.
fn lag_s(walks: &Walks, before: &[f64], after: &[f64], from_s: f64) -> f64 {
    let samples = walks.at(from_s)..walks.at(from_s + 1.0);
    let error = |lag: i32| -> f64 {
        let shifted = |index: usize| before[(index as i32 - lag) as usize];
        let errors = samples.clone().map(|index| after[index] - shifted(index));
        errors.map(|error| error * error).sum()
    };
    let best = (-12..=12).min_by(|a, b| error(*a).total_cmp(&error(*b)));
    f64::from(best.expect("some lag is best")) * WalkRecord::PERIOD_S
}

/// Lags of a robot whose swing is large, after one and a half, three and a half, and five and a
/// half seconds.
fn lags_s(kind: &str, value: f64) -> [f64; 3] {
    let walks = Walks::lasting(7.0);
    let before = walks.of(&turning());
    let after = walks.of(&changed(turning(), kind, Place::Robot, &[value]));
    [1.5, 3.5, 5.5].map(|from_s| lag_s(&walks, &before.roll, &after.roll, from_s))
}

#[test]
fn a_delay_shifts_the_whole_walk_by_itself() {
    for kind in ["sensor_delay", "servo_lag"] {
        for delay_s in [0.0, 0.08, 0.12] {
            for lag_s in lags_s(kind, delay_s) {
                assert!((lag_s - delay_s).abs() < 1e-9, "{kind} {delay_s}: {lag_s}");
            }
        }
    }
}

#[test]
fn a_longer_period_slows_the_gait_more_and_more_and_a_shorter_one_hastens_it() {
    for scale_less_1 in [-0.04, 0.04] {
        let lags_s = lags_s("gait_period", scale_less_1);
        for (lag_s, middle_s) in lags_s.iter().zip([2.0, 4.0, 6.0]) {
            let expected_s = scale_less_1 * middle_s;
            assert!(
                (lag_s - expected_s).abs() <= WalkRecord::PERIOD_S + 1e-9,
                "{lags_s:?}"
            );
        }
        // Unlike a delay, it is not the same everywhere.
        assert!(
            (lags_s[2] - lags_s[0]).abs() > 2.0 * WalkRecord::PERIOD_S,
            "{lags_s:?}"
        );
    }
}

#[test]
fn a_longer_period_slows_a_trajectory_as_it_slows_the_gait_of_feet() {
    let walks = Walks::lasting(6.0);
    let on_rows = || {
        let mut model = turning();
        let joints = JointTrajectory::commanded(&model.robot, &model.gait, 6.0).unwrap();
        model.gait.motion = Motion::Joints(joints);
        model
    };
    let roll = |model| walks.of(&model).roll;
    let slower = |model| changed(model, "gait_period", Place::Robot, &[0.04]);
    let samples = walks.at(1.0)..walks.at(5.5);
    let apart_deg = |a: &[f64], b: &[f64]| {
        let squares = samples.clone().map(|index| (a[index] - b[index]).powi(2));
        mean(&squares.collect::<Vec<_>>()).sqrt()
    };
    let rows_deg = apart_deg(&roll(slower(on_rows())), &roll(slower(turning())));
    let slowed_deg = apart_deg(&roll(slower(turning())), &roll(turning()));
    assert!(rows_deg < 0.1 * slowed_deg, "{rows_deg} {slowed_deg}");
    assert!(apart_deg(&roll(on_rows()), &roll(turning())) < 1e-9);
}

#[test]
fn only_delays_shift_the_whole_walk() {
    let kinds = LIBRARY.iter().filter(|effect| effect.is_a_delay());
    let kinds: Vec<&str> = kinds.map(|effect| effect.kind()).collect();
    assert_eq!(kinds, ["servo_lag", "sensor_delay"]);
}
