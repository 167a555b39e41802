//! `explain-servo` through the program, on a real servo.

use std::fs;

use crate::program::Folder;
use serde_json::Value;

fn real(name: &str) -> String {
    let root = env!("CARGO_MANIFEST_DIR");
    format!("{root}/../../data/real/servo-xl330/{name}")
}

fn recordings(gains: &[&str], trajectories: &[&str]) -> Vec<String> {
    let each = gains.iter().flat_map(|gain| {
        let of = trajectories.iter();
        of.map(move |trajectory| real(&format!("{gain}-{trajectory}.csv.gz")))
    });
    each.collect()
}

fn median(mut errors: Vec<f64>) -> f64 {
    errors.sort_by(f64::total_cmp);
    let middle = errors.len() / 2;
    0.5 * (errors[middle] + errors[errors.len() - 1 - middle])
}

/// Motor, rotor and the friction of gears: no search, for time.
const KINDS: &str = "motor_torque,position_gain,torque_saturation,armature,viscous_friction,\
    load_friction,stribeck_friction,gravity_offset";

#[test]
fn a_real_servo_is_predicted_on_trajectories_and_a_gain_that_were_not_fitted() {
    let folder = Folder::new();
    let bench = real("bench.toml");
    let (section, plot) = (folder.path("servo.toml"), folder.path("servo.svg"));
    let fitted = recordings(&["kp100", "kp800"], &["sin-time-square"]);
    let mut unseen = recordings(&["kp100", "kp800"], &["sin-sin", "up-and-down"]);
    unseen.extend(recordings(
        &["kp400"],
        &["sin-sin", "up-and-down", "sin-time-square", "lift-and-drop"],
    ));
    let mut arguments = vec!["explain-servo", &bench, "--json", "--effects", KINDS];
    arguments.extend(["-o", &section, "--plot", &plot]);
    arguments.extend(fitted.iter().map(String::as_str));
    arguments.extend(unseen.iter().flat_map(|test| ["--test", test]));
    let output = folder.program(&arguments).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["schema"], "mlr.servo_explanation/1");

    let errors = |fitted: bool, when: &str| -> Vec<f64> {
        let all = found["recordings"].as_array().unwrap().iter();
        let of = all.filter(|one| one["fitted"] == fitted);
        of.map(|one| one[when].as_f64().unwrap()).collect()
    };
    assert_eq!(
        (
            errors(true, "after_deg").len(),
            errors(false, "after_deg").len()
        ),
        (2, 8)
    );
    for (fitted, most_deg) in [(true, 2.0), (false, 3.5)] {
        let (before, after) = (errors(fitted, "before_deg"), errors(fitted, "after_deg"));
        assert!(median(before) > 10.0);
        let after = median(after);
        assert!(after < most_deg, "fitted {fitted}: {after}°");
    }
    // The controller makes half of the effort that the data sheet says, and the gears have friction.
    let value = |kind: &str, name: &str| {
        let effects = found["effects"].as_array().unwrap();
        let effect = effects.iter().find(|one| one["kind"] == kind).unwrap();
        effect["parameters"][name].as_f64().unwrap()
    };
    let gain = value("position_gain", "gain");
    assert!((gain / 0.4957 - 1.0).abs() < 0.01, "{gain}");
    assert!(value("load_friction", "coefficient") > 0.05);

    // What it writes is the servo of a robot description.
    let written = fs::read_to_string(&section).unwrap();
    let robot = mlr_model::Robot::JETHEXA_TOML;
    let (head, rest) = robot.split_once("[servo]").unwrap();
    let (_, tail) = rest.split_once("\n[links.coxa]").unwrap();
    let robot = format!("{head}{written}\n[links.coxa]{tail}");
    let servo = *mlr_model::Robot::from_toml(&robot).unwrap().servo();
    assert!(
        servo.drive.torque_saturation > 0.3 && servo.drive.armature_kg_m2 > 5e-4,
        "{servo:?}"
    );
    assert!(
        fs::read_to_string(&plot)
            .unwrap()
            .contains("kp400-lift-and-drop, unseen")
    );
}

#[test]
fn what_is_wrong_with_bench_recording_or_kind_is_named() {
    let folder = Folder::new();
    let bench = real("bench.toml");
    let recording = real("kp100-sin-sin.csv.gz");
    let text = fs::read_to_string(&bench).unwrap();
    let heavy = folder.write("heavy.toml", text.replace("mass_kg = 0.49", "mass_kg = -1"));
    let gainless = folder.write("gainless.toml", text.replace("p_gain = 100", ""));
    let still: String = (0..100)
        .map(|k| format!("{},0,0.1\n", f64::from(k) * 0.01))
        .collect();
    let still = folder.write("still.csv", format!("t_s,goal_rad,position_rad\n{still}"));
    let unnamed = folder.write("unnamed.csv", "time,goal_rad,position_rad\n0,0,0\n");
    for (arguments, status, expected) in [
        (vec![&*heavy, &recording], 2, "arm.mass_kg"),
        (vec![&*gainless, &recording], 2, "[reference] p_gain"),
        (
            vec![&*bench, &still],
            1,
            "still.csv: the servo moves by 0.000 rad",
        ),
        (vec![&*bench, &unnamed], 2, "no column \"t_s\""),
        (
            vec![&*bench, &recording, "--effects", "rust"],
            2,
            "expected one of motor_torque",
        ),
    ] {
        let all = [&["explain-servo"][..], &arguments].concat();
        let output = folder.program(&all).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{said}");
        assert!(said.contains(expected), "{said}");
    }
}
