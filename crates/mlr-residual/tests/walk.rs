//! Walks of the model itself with an effect that the model is not told of.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use mlr_filter::{Axes, OrientationSeries};
use mlr_model::{
    Fault, Gait, Morphology, Outcome, Robot, SimulationSettings, Simulator, Trajectory,
};
use mlr_residual::walk::{
    Beforehand, EvidenceSettings, Reported, Rival, Suspect, WalkExplanation, WalkModel, WalkRecord,
    explain_walk,
};
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Records and model are simulated in steps twice as long as usual: each takes half the time.
fn simulation() -> SimulationSettings {
    SimulationSettings {
        time_step_s: 0.02,
        ..SimulationSettings::default()
    }
}

/// What a healthy robot with these faults reports.
fn recorded(faults: Vec<Fault>) -> OrientationSeries {
    recorded_of(&healthy(), faults)
}

/// What a robot with these faults reports, with 0.02° of noise, standing for a second and walking for four.
fn recorded_of(morphology: &Morphology, faults: Vec<Fault>) -> OrientationSeries {
    let settings = SimulationSettings {
        duration_s: 4.4,
        stand_s: 1.0,
        faults,
        ..simulation()
    };
    let simulator = Simulator::new(Robot::jethexa(), &Gait::tripod(), settings).unwrap();
    let Outcome::Walked(Trajectory { orientation, .. }) = simulator.simulate(morphology) else {
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

/// The explanation of a record of a robot that is suspected to have this morphology; any other is as
/// likely.
fn explained_as(record: &WalkRecord, morphology: Morphology) -> WalkExplanation {
    // Single effects on one robot: less has to be tried.
    explained_with(record, &[morphology], 6)
}

/// The same of a robot that may have these morphologies, with so many hypotheses in the race.
fn explained_with(
    record: &WalkRecord,
    morphologies: &[Morphology],
    entrants: usize,
) -> WalkExplanation {
    let suspects = morphologies.iter().map(|morphology| Suspect {
        morphology: morphology.clone(),
        ln_prior: 0.0,
    });
    let suspects: Vec<Suspect> = suspects.collect();
    let model = WalkModel::nominal(Robot::jethexa(), Gait::tripod(), simulation());
    let mut settings = EvidenceSettings::default();
    (settings.effort.most_effects, settings.effort.entrants) = (1, entrants);
    (settings.effort.bases, settings.effort.screened) = (1, 1);
    settings.effort.neighbours = 4;
    let known = Beforehand {
        ln_morphology: &|_| 0.0,
        effects: None,
    };
    let random = ChaCha8Rng::seed_from_u64(1);
    let found = explain_walk(record, &model, &suspects, known, &settings, &random, &());
    found.unwrap()
}

fn explained(faults: Vec<Fault>) -> WalkExplanation {
    let record = WalkRecord::new(&recorded(faults), 0.0, false, 0.0, None).unwrap();
    explained_as(&record, healthy())
}

fn healthy() -> Morphology {
    Morphology::healthy(&Robot::jethexa().layout())
}

/// The answer is a distribution: `none` and `unknown` have their share, every hypothesis counts for
/// each of its kinds, and the effects are those of the most probable one.
fn expect_probabilities(found: &WalkExplanation) {
    let of = &found.effect_probability;
    let is_share = |p: &f64| (0.0..=1.0 + 1e-9).contains(p);
    assert!(of.values().all(is_share), "{of:?}");
    let (none, unknown) = (of["none"], of["unknown"]);
    assert!(none + unknown < 1.0 + 1e-9, "{of:?}");
    assert!(of.values().sum::<f64>() > 1.0 - 1e-9, "{of:?}");
    assert_eq!(found.unexplained, unknown > 0.5, "{of:?}");
    for effect in &found.effects {
        assert!((effect.probability - of[&effect.kind]).abs() < 1e-9);
    }
    let one_by_one: Vec<f64> = found.alternatives.iter().map(|a| a.probability).collect();
    assert!(one_by_one.is_sorted_by(|a, b| a >= b), "{one_by_one:?}");
    assert!(one_by_one.iter().sum::<f64>() < 1.0 + 1e-9);
    let best = found.alternatives.iter().find(|one| !one.unknown).unwrap();
    assert_eq!(best.morphology, found.morphology);
    assert_eq!(kinds(&best.effects), kinds_found(found));
}

fn kinds(effects: &[Rival]) -> Vec<&str> {
    effects.iter().map(|effect| effect.kind.as_str()).collect()
}

/// Of the effects, but for lost links that are locked.
fn kinds_found(found: &WalkExplanation) -> Vec<&str> {
    let kinds = found.effects.iter().map(|effect| effect.kind.as_str());
    kinds.filter(|kind| *kind != "locked_links").collect()
}

#[test]
fn where_the_model_lacks_nothing_nothing_is_added() {
    let found = explained(Vec::new());
    expect_probabilities(&found);
    assert_eq!(found.effects, [], "{:?}", found.effects);
    assert!(
        found.effect_probability["none"] > 0.6,
        "{:?}",
        found.effect_probability
    );
    // A small payload walks like none: it is improbable and not ruled out. A bias shows.
    let of = |kind: &str| found.effect_probability.get(kind).copied().unwrap_or(0.0);
    assert!((1e-3..0.1).contains(&of("payload")), "{}", of("payload"));
    assert!(of("gyro_bias") < 1e-3, "{}", of("gyro_bias"));
    assert!(!found.unexplained, "{:?}", found.residual);
    assert!(found.error_after.validation_deg < 0.1);
    assert_eq!(found.morphology, healthy());
    assert!(found.damaged_legs.is_empty());
    // Nothing is out of the ordinary.
    assert!(found.nuisance.values().all(|z_score| z_score.abs() < 1.5));
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
    expect_probabilities(&found);
    assert_eq!(found.morphology, healthy());
    // An offset of the joint above it, or a joint that is stuck, makes nearly the same walk.
    let of = &found.effect_probability;
    let of_leg = of["short_link"] + of["joint_offset"] + of["stuck_joint"];
    assert!(of["short_link"] > 0.5 && of_leg > 0.9, "{of:?}");
    assert!(found.error_after.validation_deg < 0.2 * found.error_calibrated.validation_deg);
}

#[test]
fn an_effect_that_the_race_has_missed_is_found_beside_the_likeliest_robot() {
    let short = recorded(vec![Fault::ShortLink {
        leg: 5,
        link: 3,
        length_lost_m: 0.03,
    }]);
    let record = WalkRecord::new(&short, 0.0, false, 0.0, None).unwrap();
    let found = explained_with(&record, &[healthy()], 0);
    expect_probabilities(&found);
    let [effect] = &found.effects[..] else {
        panic!("{:?}", found.effects);
    };
    assert_eq!(effect.kind, "short_link");
    assert_eq!(effect.parameters["leg"], Reported::Number(5));
}

#[test]
fn a_leg_that_gives_way_is_told_from_a_lost_one() {
    let weak = recorded(vec![Fault::WeakLeg { leg: 3, gain: 0.15 }]);
    let record = WalkRecord::new(&weak, 0.0, false, 0.0, None).unwrap();
    // As an identification that knows of lost legs only would have it.
    let found = explained_as(&record, healthy().without_leg(2));
    expect_probabilities(&found);
    assert_eq!(found.morphology, healthy());
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
fn a_leg_that_gives_way_is_told_from_a_lost_one_on_a_robot_that_lacks_others() {
    let legs_lost = |text: &str| {
        let layout = Robot::jethexa().layout();
        Morphology::parse_legs_lost(text, &layout).unwrap()
    };
    let short = Fault::ShortLink {
        leg: 3,
        link: 3,
        length_lost_m: 0.0335,
    };
    let record = recorded_of(&legs_lost("4,6"), vec![short]);
    let record = WalkRecord::new(&record, 0.0, false, 0.0, None).unwrap();
    // One that comes near, and one that lacks the short leg too, which is fitted no further than the first step.
    let found = explained_with(&record, &[legs_lost("3,4"), legs_lost("3,4,6")], 12);
    expect_probabilities(&found);
    assert_eq!(found.morphology, legs_lost("4,6"));
    let [effect] = &found.effects[..] else {
        panic!("{:?}", found.effects);
    };
    assert_eq!(effect.parameters["leg"], Reported::Number(3));
}

#[test]
fn a_bias_that_shows_at_rest_is_found_by_its_axis() {
    const BIAS_DPS: f64 = 2.5;
    let fine = recorded(Vec::new());
    let mut angles_rad = fine.angles_rad().clone();
    for (yaw_rad, time_s) in angles_rad.yaw.iter_mut().zip(fine.times_s()) {
        *yaw_rad += BIAS_DPS.to_radians() * time_s;
    }
    let biased = OrientationSeries::new(fine.times_s().to_vec(), angles_rad).unwrap();
    let rest_dps = Some([0.0, 0.0, BIAS_DPS]);
    let record = WalkRecord::new(&biased, 0.0, false, 0.0, rest_dps).unwrap();
    let found = explained_as(&record.dead_reckoned(), healthy());
    expect_probabilities(&found);
    assert_eq!(found.morphology, healthy());
    let [effect] = &found.effects[..] else {
        panic!("{:?}", found.effects);
    };
    assert_eq!(effect.kind, "gyro_bias");
    let Reported::Quantity(bias_dps) = effect.parameters["z_dps"] else {
        panic!("{:?}", effect.parameters);
    };
    assert!((bias_dps - BIAS_DPS).abs() < 0.2, "{bias_dps}");
}
