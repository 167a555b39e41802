//! Servos whose effects are known: recordings of the bench itself.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use mlr_model::{
    Drive, Servo,
    bench::{Arm, Bench, Command, Reference, Swing},
};
use mlr_residual::servo::{
    ServoError, ServoExplanation, ServoModel, ServoRecording, ServoSettings, explain_servo,
};

const RATE_HZ: f64 = 200.0;
const SAMPLES: usize = 600;

fn described() -> Bench {
    Bench {
        name: "test".into(),
        arm: Arm {
            mass_kg: 0.5,
            length_m: 0.1,
            inertia_kg_m2: 0.0,
            hanging_rad: 0.0,
        },
        servo: Servo {
            stiffness_nm_per_rad: 2.0,
            damping_nm_s_per_rad: 0.05,
            torque_limit_nm: 1.0,
            speed_limit_rad_per_s: 1e3,
            command_hold_s: 0.005,
            latency_s: 0.0,
            drive: Drive::default(),
        },
        reference: Reference::default(),
    }
}

/// Three seconds of a servo that is commanded to swing, to a 12-bit encoder's resolution.
fn recorded(bench: &Bench, amplitude_rad: f64) -> ServoRecording {
    let times_s: Vec<f64> = (0..SAMPLES).map(|k| k as f64 / RATE_HZ).collect();
    let goal = |t: f64| amplitude_rad * (4.0 * t + t * t).sin();
    let command = |t: &f64| Command {
        time_s: *t,
        goal_rad: goal(*t),
        motor_on: *t < 2.2,
        stiffness: 1.0,
        torque: 1.0,
    };
    let commands: Vec<Command> = times_s.iter().map(command).collect();
    // A finer step than the model's, so that it is not its own data.
    let swing = Swing::new(bench, &commands, 0.0, 0.1 / RATE_HZ);
    let angles = swing.angles_rad(10 * SAMPLES).unwrap();
    let step_rad = std::f64::consts::TAU / 4096.0;
    let reported = angles.iter().step_by(10).take(SAMPLES);
    ServoRecording {
        name: format!("{amplitude_rad} rad"),
        goals_rad: times_s.iter().map(|t| goal(*t)).collect(),
        positions_rad: reported
            .map(|a| (a / step_rad).round() * step_rad)
            .collect(),
        motor_on: times_s.iter().map(|t| *t < 2.2).collect(),
        supply_v: Vec::new(),
        p_gain: Vec::new(),
        load: Vec::new(),
        times_s,
    }
}

/// Looks for a few kinds that are easily told apart, for time.
fn explained(truth: &Bench) -> ServoExplanation {
    let kept = [
        "armature",
        "coulomb_friction",
        "command_delay",
        "gravity_offset",
    ];
    let others = mlr_residual::servo_effects::LIBRARY
        .iter()
        .map(|e| e.kind());
    let settings = ServoSettings {
        effects: None,
        without: others
            .filter(|kind| !kept.contains(kind))
            .map(String::from)
            .collect(),
    };
    let recordings = [recorded(truth, 0.6), recorded(truth, -0.9)];
    let described = ServoModel::new(described());
    let (fitted, unseen) = recordings.split_at(1);
    explain_servo(&described, fitted, unseen, &settings, &()).unwrap()
}

fn kinds(found: &ServoExplanation) -> Vec<&str> {
    let mut kinds: Vec<&str> = found.effects.iter().map(|e| e.kind.as_str()).collect();
    kinds.sort_unstable();
    kinds
}

#[test]
fn friction_and_rotor_are_found_with_their_sizes_and_predict_what_was_not_fitted() {
    let mut truth = described();
    truth.servo.drive = Drive {
        coulomb_nm: 0.06,
        armature_kg_m2: 0.002,
        ..Drive::default()
    };
    let found = explained(&truth);
    assert_eq!(kinds(&found), ["armature", "coulomb_friction"]);
    for effect in &found.effects {
        let (name, size) = match effect.kind.as_str() {
            "armature" => ("armature_kg_m2", 0.002),
            _ => ("coulomb_nm", 0.06),
        };
        let value = effect.parameters[name];
        assert!((value / size - 1.0).abs() < 0.1, "{name} {value}");
        let [low, high] = effect.interval_95[name];
        assert!(
            low < value && value < high && high - low < size,
            "{effect:?}"
        );
        assert!(effect.ln_gain > 0.0 && effect.probability > 0.9);
    }
    let [fitted, unseen] = &found.recordings[..] else {
        panic!("two recordings")
    };
    assert!(fitted.fitted && !unseen.fitted);
    assert!(
        unseen.before_deg > 2.0 && unseen.after_deg < 0.3,
        "{unseen:?}"
    );
}

/// The effort of its controller, in pulse widths as the servo reports them.
fn with_load(mut recording: ServoRecording, servo: &Servo) -> ServoRecording {
    let pairs = recording.goals_rad.iter().zip(&recording.positions_rad);
    let loads = pairs.map(|(goal, angle)| (LARGEST_LOAD * servo.effort(goal - angle)).round());
    recording.load = loads.collect();
    recording
}

const LARGEST_LOAD: f64 = 885.0;

#[test]
fn the_effort_that_a_servo_reports_tells_its_gain_from_a_motor_that_saturates() {
    let (gain, saturation) = (0.5, 0.6);
    let mut truth = described();
    truth.servo.stiffness_nm_per_rad *= gain * (1.0 + saturation);
    truth.servo.drive.torque_saturation = saturation;
    let recording = with_load(recorded(&truth, 0.9), &truth.servo);
    let settings = ServoSettings {
        effects: Some(
            ["position_gain", "torque_saturation"]
                .map(String::from)
                .into(),
        ),
        without: Vec::new(),
    };
    let fitted = |largest_load: Option<f64>| {
        let mut bench = described();
        bench.reference.load = largest_load;
        let recordings = [recording.clone()];
        explain_servo(&ServoModel::new(bench), &recordings, &[], &settings, &()).unwrap()
    };
    let value = |found: &ServoExplanation, kind: &str, name: &str| {
        let effect = found.effects.iter().find(|one| one.kind == kind).unwrap();
        let [low, high] = effect.interval_95[name];
        (effect.parameters[name], high - low)
    };
    let told = fitted(Some(LARGEST_LOAD));
    let (found, width) = value(&told, "position_gain", "gain");
    assert!((found / gain - 1.0).abs() < 0.01, "{found}");
    let (found, _) = value(&told, "torque_saturation", "saturation");
    assert!((found / saturation - 1.0).abs() < 0.2, "{found}");
    // Control: the motion alone tells it far less surely.
    let (_, guessed) = value(&fitted(None), "position_gain", "gain");
    assert!(guessed > 3.0 * width, "{guessed} {width}");
}

#[test]
fn a_servo_as_described_has_no_effects() {
    let found = explained(&described());
    assert_eq!(kinds(&found), [""; 0]);
    // Of the model's step, which is ten times that of the recording.
    let errors: Vec<f64> = found.recordings.iter().map(|one| one.after_deg).collect();
    assert!(errors.iter().all(|error| *error < 0.6), "{errors:?}");
    assert_eq!(found.servo, described().servo);
}

#[test]
fn a_recorded_gain_needs_one_to_compare_with() {
    let mut recording = recorded(&described(), 0.6);
    recording.p_gain = vec![400.0; SAMPLES];
    let model = ServoModel::new(described());
    let settings = ServoSettings::default();
    let error = explain_servo(&model, &[recording], &[], &settings, &()).unwrap_err();
    assert_eq!(error, (0, ServoError::GainWithoutReference));
}
