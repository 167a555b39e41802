//! Every number that a configuration can hold is checked, and refused by its name.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../../mlr-model/tests/toml_numbers/mod.rs"]
mod toml_numbers;

use mlr_ga::{Configuration, ConfigurationError, IdentifySettings, WalkStart};
use mlr_model::{Fault, Payload, Robot, Roughness};
use proptest::prelude::*;
use toml::Value;
use toml_numbers::at;

/// Settings that name everything that may be left out.
fn complete() -> Configuration {
    let mut settings = IdentifySettings {
        walk_start: WalkStart::CommandedAtS(2.0),
        from_s: Some(3.0),
        ..IdentifySettings::default()
    };
    // The others are like them.
    settings.variations.truncate(2);
    settings.genetic.patience = Some(5);
    let simulation = &mut settings.simulation;
    simulation.payload = Some(Payload {
        mass_kg: 0.3,
        position_m: [0.1, -0.1, 0.02],
    });
    simulation.terrain.roughness = Some(Roughness {
        height_m: 0.005,
        spacing_m: 0.05,
        seed: 1,
    });
    let (leg, joint, angle_rad) = (1, 2, 0.1);
    simulation.faults = vec![
        Fault::FootFriction { leg, mu: 0.5 },
        Fault::WeakLeg { leg, gain: 0.5 },
        Fault::StuckJoint {
            leg,
            joint,
            angle_rad,
        },
        Fault::JointOffset {
            leg,
            joint,
            angle_rad,
        },
        Fault::ShortLink {
            leg,
            link: 3,
            length_lost_m: 0.01,
        },
        Fault::ExternalForce { force_n: [0.1; 3] },
    ];
    Configuration {
        identification: settings,
        ..Configuration::default()
    }
}

/// Keys for which zero is a sensible number, besides those that may be negative.
const MAY_BE_ZERO: &[&str] = &[
    // Nothing is forgiven, asked for, or removed.
    "identification.max_dropped_share",
    "identification.credible_share",
    "identification.filter.power_threshold_deg2",
    "identification.motion.noise_factor",
    "identification.motion.moving_share",
    "identification.motion.response_s",
    "identification.detector.persistence_s",
    "identification.detector.lull_s",
    // The engine walks like the robot's own body.
    "explanation.nuisance.engine_bias",
    // Every sensor is trusted; axes err independently of each other.
    "identification.plausibility.defective_sensor",
    "identification.plausibility.usual.correlation",
    "identification.plausibility.unexplained.correlation",
    // The initial populations are all there is; nothing is crossed, mutated or drawn.
    "identification.genetic.generations",
    "identification.genetic.crossover_rate",
    "identification.genetic.mutation_rate",
    "identification.genetic.link_probability",
    // The best plan that was looked at is taken as it is.
    "recovery.generations",
    // Ice, level ground, and no payload.
    "identification.variations[0].friction",
    "identification.variations[1].friction",
    "identification.variations[0].payload",
    "identification.variations[1].payload",
    "identification.variations[0].slope_deg",
    "identification.variations[1].slope_deg",
    "identification.simulation.settle_s",
    "identification.simulation.stand_s",
    "identification.simulation.start_clearance_m",
    "identification.simulation.contact.friction",
    "identification.simulation.terrain.slope_rad",
    "identification.simulation.terrain.roughness.height_m",
    "identification.simulation.terrain.roughness.seed",
    "identification.simulation.payload.mass_kg",
    "identification.simulation.faults[0].mu",
    "identification.simulation.faults[4].length_lost_m",
    // Robots do not differ by this; a part of the error is not there; nothing is tried.
    "explanation.nuisance",
    "explanation.discrepancy.turning",
    "explanation.discrepancy.tilt.harmonic_decay",
    "explanation.discrepancy.tilt.white.swing_share",
    "explanation.discrepancy.tilt.white.spread_share",
    "explanation.discrepancy.tilt.white.impacts_share",
    "explanation.discrepancy.tilt.constant.",
    "explanation.discrepancy.tilt.periodic.",
    "explanation.discrepancy.tilt.irregular.",
    "explanation.discrepancy.tilt.ln_scale_spread",
    "explanation.discrepancy.tilt.scatter_share",
    "explanation.discrepancy.tilt.impacts_share",
    "explanation.discrepancy.yaw.harmonic_decay",
    "explanation.discrepancy.yaw.white.swing_share",
    "explanation.discrepancy.yaw.white.spread_share",
    "explanation.discrepancy.yaw.white.impacts_share",
    "explanation.discrepancy.yaw.constant.",
    "explanation.discrepancy.yaw.periodic.",
    "explanation.discrepancy.yaw.irregular.",
    "explanation.discrepancy.yaw.ln_scale_spread",
    "explanation.discrepancy.yaw.scatter_share",
    "explanation.discrepancy.yaw.impacts_share",
    "explanation.effort",
];

/// Keys for which a negative number is sensible: directions, places and log times.
const MAY_BE_NEGATIVE: &[&str] = &[
    "mounting.roll_deg",
    "mounting.pitch_deg",
    "mounting.yaw_deg",
    "mounting.accelerometer_bias_mps2",
    // One entry of it: the matrix must stay near the identity.
    "mounting.accelerometer_scale",
    "identification.walk_start",
    "identification.from_s",
    "identification.variations[0].payload_at",
    "identification.variations[1].payload_at",
    "identification.variations[0].uphill_deg",
    "identification.variations[1].uphill_deg",
    "identification.simulation.terrain.uphill_rad",
    "identification.simulation.payload.position_m",
    "identification.simulation.faults[2].angle_rad",
    "identification.simulation.faults[3].angle_rad",
    "identification.simulation.faults[5].force_n",
];

/// Keys for which any whole number is sensible.
const MAY_BE_ANY: &[&str] = &["identification.simulation.terrain.roughness.seed"];

fn is_among(keys: &[&str], path: &str) -> bool {
    // Two tables of one type.
    let path = path.replace("mean_discrepancy", "discrepancy");
    keys.iter().any(|key| path.starts_with(key))
}

fn document() -> Value {
    Value::try_from(complete()).unwrap()
}

/// Reads the complete configuration with one number replaced, and checks it with a robot.
fn read_with(path: &str, number: Value) -> Result<(), ConfigurationError> {
    let mut document = document();
    *at(&mut document, path) = number;
    let text = toml::to_string(&document).unwrap();
    let configuration = Configuration::from_toml(&text)?;
    let with_robot = configuration.identification.check_on(&Robot::jethexa());
    with_robot.map_err(|error| error.under("identification").into())
}

/// The error must name the key: by its path, or, for a matrix whose entries do not go
/// together, by the matrix; where the number is not even of the right kind, by showing it.
fn names(error: &ConfigurationError, path: &str) -> bool {
    match error {
        ConfigurationError::Setting(error) => {
            error.name == path || path.starts_with(&format!("{}[", error.name))
        }
        ConfigurationError::Syntax(error) => {
            // Of a fault, whose kind decides what its keys mean, the section is shown.
            let key = match path.contains("faults[") {
                true => "faults",
                false => path.rsplit('.').next().unwrap(),
            };
            let key = key.split('[').next().unwrap();
            error.to_string().contains(key)
        }
    }
}

#[test]
fn the_complete_configuration_is_accepted() {
    let mut document = document();
    let paths = toml_numbers::paths(&document);
    assert!(paths.len() > 100, "{paths:?}");
    let first = at(&mut document, &paths[0]).clone();
    read_with(&paths[0], first).unwrap();
}

#[test]
fn every_number_is_accepted_with_sense_or_refused_by_name() {
    let mut document = document();
    let paths = toml_numbers::paths(&document);
    for path in &paths {
        let is_whole = at(&mut document, path).is_integer();
        let whole = |number: i64| match is_whole {
            true => Value::Integer(number),
            false => Value::Float(number as f64),
        };
        let negative = is_among(MAY_BE_NEGATIVE, path);
        for (number, accepted) in [
            (Value::Float(f64::NAN), false),
            (Value::Float(f64::INFINITY), false),
            (Value::Float(f64::NEG_INFINITY), false),
            (Value::Float(1e300), false),
            (Value::Float(-1e300), false),
            (whole(i64::MAX), is_among(MAY_BE_ANY, path)),
            (whole(-1), negative),
            (whole(0), negative || is_among(MAY_BE_ZERO, path)),
        ] {
            match read_with(path, number.clone()) {
                Ok(()) => assert!(accepted, "{path} = {number} is accepted"),
                // A matrix that one entry spoils is named, whatever the entry.
                Err(error) if path.contains("accelerometer_scale") => {
                    assert!(names(&error, path), "{path} = {number}: {error}");
                }
                Err(error) => {
                    assert!(!accepted, "{path} = {number} is refused: {error}");
                    assert!(names(&error, path), "{path} = {number}: {error}");
                }
            }
        }
    }
}

#[test]
fn no_exception_is_listed_in_vain() {
    let paths = toml_numbers::paths(&document());
    for key in MAY_BE_ZERO.iter().chain(MAY_BE_NEGATIVE).chain(MAY_BE_ANY) {
        assert!(paths.iter().any(|path| path.starts_with(key)), "{key}");
    }
}

#[test]
fn lists_that_must_not_be_empty_are_named() {
    for key in ["variations", "genetic.link_probability"] {
        let path = format!("identification.{key}");
        let error = read_with(&path, Value::Array(Vec::new())).unwrap_err();
        assert!(names(&error, &path), "{error}");
    }
}

#[test]
fn every_way_to_know_the_start_of_the_walk_is_checked() {
    for key in ["commanded_at_s", "observed_at_s"] {
        let read = |time: &str| {
            let text = format!("[identification]\nwalk_start = {{ {key} = {time} }}");
            Configuration::from_toml(&text)
        };
        read("-2.5").unwrap();
        let message = read("nan").unwrap_err().to_string();
        let start = format!("line 2: identification.walk_start.{key}: NaN");
        assert!(message.starts_with(&start), "{message}");
    }
    let misspelt = Configuration::from_toml("walk_start = { comanded_at_s = 2.0 }");
    let message = misspelt.unwrap_err().to_string();
    assert!(message.contains("commanded_at_s"), "{message}");
}

#[test]
fn settings_that_contradict_each_other_are_named() {
    let message = |text| Configuration::from_toml(text).unwrap_err().to_string();
    let cutoff = message("[filter]\ncutoff_hz = 30.0");
    assert!(
        cutoff.contains("sampling.min_rate_hz: 45 is not valid"),
        "{cutoff}"
    );
    assert!(cutoff.contains("twice filter.cutoff_hz, 60 Hz"), "{cutoff}");
    let rate = message("[filter]\nrate_hz = 15.0");
    assert!(
        rate.starts_with("line 2: filter.rate_hz: 15 is not valid"),
        "{rate}"
    );
    let step = message("[detector]\nstep_s = 0.7");
    assert!(
        step.starts_with("line 2: detector.step_s: 0.7 is not valid"),
        "{step}"
    );
    let steps = message("[simulation]\nduration_s = 3600\ntime_step_s = 0.0001");
    assert!(
        steps.starts_with("line 3: simulation.time_step_s: 0.0001"),
        "{steps}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn whatever_is_accepted_is_finite_and_whatever_is_not_is_named(
        chosen in any::<prop::sample::Index>(),
        number in any::<f64>(),
    ) {
        let paths = toml_numbers::paths(&document());
        let path = chosen.get(&paths);
        match read_with(path, Value::Float(number)) {
            Ok(()) => prop_assert!(number.is_finite()),
            Err(error) => prop_assert!(names(&error, path), "{path} = {number}: {error}"),
        }
    }
}
