//! Walks of the model itself with an effect that the model is not told of.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::sync::atomic::{AtomicUsize, Ordering};

use mlr_filter::{Axes, OrientationSeries};
use mlr_model::{
    Fault, Gait, Morphology, Outcome, Robot, SimulationSettings, Simulator, Trajectory,
};
use mlr_residual::{
    Progress,
    walk::{
        MorphologySearch, Reported, Suspect, TracingSettings, WalkExplanation, WalkModel,
        WalkRecord, explain_walk,
    },
};
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// What a healthy robot with these faults reports, with 0.02° of noise, standing for a
/// second and walking for four.
fn recorded(faults: Vec<Fault>) -> OrientationSeries {
    let settings = SimulationSettings {
        duration_s: 4.4,
        stand_s: 1.0,
        faults,
        ..SimulationSettings::default()
    };
    let robot = Robot::jethexa();
    let healthy = Morphology::healthy(&robot.layout());
    let simulator = Simulator::new(robot, &Gait::tripod(), settings).unwrap();
    let Outcome::Walked(Trajectory { orientation, .. }) = simulator.simulate(&healthy) else {
        panic!("diverged");
    };
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut noisy = |angles_rad: &[f64]| -> Vec<f64> {
        let noise = |x: &f64| x + 0.02_f64.to_radians() * 3.4 * (random.random::<f64>() - 0.5);
        angles_rad.iter().map(noise).collect()
    };
    let axes = orientation.angles_rad();
    let angles_rad = Axes {
        roll: noisy(&axes.roll),
        pitch: noisy(&axes.pitch),
        yaw: noisy(&axes.yaw),
    };
    OrientationSeries::new(orientation.times_s().to_vec(), angles_rad).unwrap()
}

/// Nobody names other morphologies, and all are as likely.
struct NoSearch;

impl MorphologySearch for NoSearch {
    fn with_effects(&self, _: &WalkModel) -> Vec<Suspect> {
        Vec::new()
    }

    fn ln_prior(&self, _: &Morphology) -> f64 {
        0.0
    }
}

fn explained(faults: Vec<Fault>) -> WalkExplanation {
    explained_in_steps(faults).0
}

/// The same, and how many steps that took.
fn explained_in_steps(faults: Vec<Fault>) -> (WalkExplanation, usize) {
    let record = WalkRecord::new(&recorded(faults), 0.0, false, 0.0, None).unwrap();
    explained_record(&record)
}

/// The first effect that a healthy robot with this record has, and the steps to it.
fn explained_record(record: &WalkRecord) -> (WalkExplanation, usize) {
    let robot = Robot::jethexa();
    let healthy = Suspect {
        morphology: Morphology::healthy(&robot.layout()),
        ln_prior: 0.0,
    };
    let model = WalkModel::nominal(robot, Gait::tripod(), SimulationSettings::default());
    let settings = TracingSettings {
        most_effects: 1,
        ..TracingSettings::default()
    };
    let steps = Steps::default();
    let found = explain_walk(record, &model, &[healthy], &NoSearch, &settings, &steps);
    (found.unwrap(), steps.0.into_inner())
}

/// A look at every effect takes more steps than this.
const STEPS_OF_A_ROUND: usize = 150;

/// Counts steps.
#[derive(Default)]
struct Steps(AtomicUsize);

impl Progress for Steps {
    fn expect_more(&self, _: usize) {}

    fn advance(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

#[test]
fn where_the_model_lacks_nothing_nothing_is_added() {
    let (found, steps) = explained_in_steps(Vec::new());
    assert!(steps > STEPS_OF_A_ROUND, "{steps}");
    assert_eq!(found.effects, [], "{:?}", found.effects);
    assert!(!found.unexplained, "{:?}", found.residual);
    assert!(found.error_after.validation_deg < 0.1);
    assert!(found.damaged_legs.is_empty());
    // Nothing is out of the ordinary.
    let usual = found.usual_differences.values();
    assert!(usual.into_iter().all(|size| size.abs() < 1.5));
}

#[test]
fn a_short_link_is_found_on_its_leg_with_its_length() {
    let found = explained(vec![Fault::ShortLink {
        leg: 5,
        link: 3,
        length_lost_m: 0.02,
    }]);
    let [effect] = &found.effects[..] else {
        panic!("{:?}", found.effects);
    };
    assert_eq!(effect.kind, "short_link");
    assert_eq!(effect.parameters["leg"], Reported::Number(5));
    assert_eq!(effect.parameters["link"], Reported::Number(3));
    let Reported::Quantity(lost_m) = effect.parameters["length_lost_m"] else {
        panic!("{:?}", effect.parameters);
    };
    assert!((lost_m - 0.02).abs() < 0.002, "{lost_m}");
    let [low, high] = effect.interval_95["length_lost_m"];
    assert!(low < lost_m && lost_m < high, "{low} {high}");
    assert!(effect.gain.iter().all(|gain| *gain > effect.price));
    assert!(found.error_after.validation_deg < 0.2 * found.error_calibrated.validation_deg);
}

#[test]
fn a_leg_that_gives_way_is_told_from_a_lost_one() {
    let weak = recorded(vec![Fault::WeakLeg { leg: 3, gain: 0.15 }]);
    let record = WalkRecord::new(&weak, 0.0, false, 0.0, None).unwrap();
    let robot = Robot::jethexa();
    let healthy = Morphology::healthy(&robot.layout());
    // As an identification that knows of lost legs only would have it.
    let lost = Suspect {
        morphology: healthy.clone().without_leg(2),
        ln_prior: 0.0,
    };
    let model = WalkModel::nominal(robot, Gait::tripod(), SimulationSettings::default());
    let settings = TracingSettings {
        most_effects: 1,
        ..TracingSettings::default()
    };
    let found = explain_walk(&record, &model, &[lost], &NoSearch, &settings, &()).unwrap();
    assert_eq!(found.morphology, healthy);
    let [effect] = &found.effects[..] else {
        panic!("{:?}", found.effects);
    };
    assert_eq!(effect.kind, "weak_leg");
    assert_eq!(effect.parameters["leg"], Reported::Number(3));
    let Reported::Quantity(gain) = effect.parameters["gain"] else {
        panic!("{:?}", effect.parameters);
    };
    assert!((gain - 0.15).abs() < 0.05, "{gain}");
}

#[test]
fn no_effect_is_tried_before_a_bias_that_nobody_could_overlook() {
    const BIAS_DPS: f64 = 2.5;
    let fine = recorded(Vec::new());
    let mut angles_rad = fine.angles_rad().clone();
    for (yaw_rad, time_s) in angles_rad.yaw.iter_mut().zip(fine.times_s()) {
        *yaw_rad += BIAS_DPS.to_radians() * time_s;
    }
    let biased = OrientationSeries::new(fine.times_s().to_vec(), angles_rad).unwrap();
    let rest_dps = Some([0.0, 0.0, BIAS_DPS]);
    let record = WalkRecord::new(&biased, 0.0, false, 0.0, rest_dps).unwrap();
    let (found, steps) = explained_record(&record.dead_reckoned());
    assert!(steps < STEPS_OF_A_ROUND, "{steps}");
    let [effect] = &found.effects[..] else {
        panic!("{:?}", found.effects);
    };
    assert_eq!(effect.kind, "gyro_bias");
    let Reported::Quantity(bias_dps) = effect.parameters["z_dps"] else {
        panic!("{:?}", effect.parameters);
    };
    assert!((bias_dps - BIAS_DPS).abs() < 0.2, "{bias_dps}");
}
