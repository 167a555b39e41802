//! An effect at its neutral value is no effect.

use mlr_model::{Fault, Payload};

use super::*;
use crate::walk::NuisanceSettings;

/// Thousandths of what a sensor resolves.
const PRECISION_DEG: f64 = 1e-6;

/// A robot that every effect shows on, and whose description is not the plainest one: it turns,
/// carries a load and walks uphill.
fn busy() -> WalkModel {
    let mut model = described();
    let weak = Fault::WeakLeg { leg: 3, gain: 0.2 };
    model.simulation.faults.push(weak);
    model.simulation.payload = Some(Payload {
        mass_kg: 0.2,
        position_m: [0.03, -0.02, 0.05],
    });
    model.simulation.terrain.slope_rad = 0.06;
    model.simulation.terrain.uphill_rad = 0.7;
    model.sensing.bias_dps = [0.1, 0.2, -0.3];
    model
}

/// A kind at the last of its places.
fn kinds() -> impl Iterator<Item = (&'static dyn WalkEffect, Place)> {
    LIBRARY.iter().copied().map(|effect| {
        let of_kind = |(other, _): &(&'static dyn WalkEffect, Place)| other.kind() == effect.kind();
        everywhere()
            .filter(of_kind)
            .last()
            .expect("every effect has a place")
    })
}

#[test]
fn a_walk_stays_the_same_at_neutral_values_and_at_no_others() {
    let (model, walks) = (busy(), Walks::lasting(3.0));
    let plain = walks.of(&model);
    let whole = 0..plain.yaw.len();
    for (effect, place) in kinds() {
        let change_deg = |values: &[f64]| {
            let changed = changed(model.clone(), effect.kind(), place, values);
            rms(&less(&walks.of(&changed), &plain), whole.clone())
        };
        let parameters = effect.parameters(place, &model);
        let neutral: Vec<f64> = parameters.iter().filter_map(|p| p.neutral).collect();
        if neutral.len() == parameters.len() {
            let change_deg = change_deg(&neutral);
            assert!(
                change_deg < PRECISION_DEG,
                "{}: {change_deg}",
                effect.kind()
            );
        }
        // Control: a value that is no surprise where the effect is present.
        let present: Vec<f64> = parameters.iter().map(|p| p.value(0.7)).collect();
        let change_deg = change_deg(&present);
        assert!(
            change_deg > 1e4 * PRECISION_DEG,
            "{}: {change_deg}",
            effect.kind()
        );
    }
}

#[test]
fn only_a_stuck_joint_has_no_neutral_value() {
    for (effect, place) in kinds() {
        let parameters = effect.parameters(place, &described());
        let has_neutral = parameters.iter().all(|p| p.neutral.is_some());
        assert_eq!(
            has_neutral,
            effect.kind() != "stuck_joint",
            "{}",
            effect.kind()
        );
    }
}

#[test]
fn an_effect_does_what_the_nuisance_parameters_do_that_it_stands_for() {
    let (model, walks) = (busy(), Walks::lasting(3.0));
    let plain = walks.of(&model);
    let whole = 0..plain.yaw.len();
    let settings = NuisanceSettings::default();
    let mut standing: Vec<&str> = Vec::new();
    for (effect, place) in kinds() {
        let replaced = effect.replaces(place);
        let mut unusual = model.clone();
        // A clock that differs shifts the walk in time, and does not let the feet move faster: both are alike where
        // the shift is large beside that.
        let (times, most) = match effect.kind() {
            "gait_period" => (10.0, 0.5),
            _ => (1.0, 1e-6),
        };
        for (nuisance, z_score) in replaced.iter().zip([2.0, -1.5, 1.0]) {
            nuisance.apply(&settings, times * z_score, &walks.record, &mut unusual);
        }
        let changes = replaced.iter().map(|one| one.change(&model, &unusual));
        let changes: Vec<f64> = changes.collect();
        let Some(values) = effect.standing_for(&changes) else {
            continue;
        };
        standing.push(effect.kind());
        let by_nuisance = walks.of(&unusual);
        let by_effect = walks.of(&changed(model.clone(), effect.kind(), place, &values));
        let change_deg = rms(&less(&by_nuisance, &plain), whole.clone());
        assert!(change_deg > 1e-3, "{}: {change_deg}", effect.kind());
        let apart_deg = rms(&less(&by_effect, &by_nuisance), whole.clone());
        assert!(
            apart_deg < most * change_deg + PRECISION_DEG,
            "{}: {apart_deg} of {change_deg}",
            effect.kind()
        );
    }
    standing.sort_unstable();
    let expected = [
        "friction",
        "gait_period",
        "gyro_scale",
        "imu_misalignment",
        "joint_offset",
        "servo_stiffness",
    ];
    assert_eq!(standing, expected);
}
