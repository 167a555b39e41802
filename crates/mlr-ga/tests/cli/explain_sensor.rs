//! `explain-sensor` through the program, on a real gyroscope beside a shaft encoder.

use crate::program::Folder;
use serde_json::Value;

const ROLL: [&str; 2] = ["--rate", "g2x_dps"];
const YAW: [&str; 4] = ["--rate", "g2z_dps", "--sign", "-1"];

fn real(name: &str) -> String {
    format!(
        "{}/../../data/real/mpu6050-encoder/{name}.csv.gz",
        env!("CARGO_MANIFEST_DIR")
    )
}

/// The JSON object printed; warnings may go to stderr.
fn report(folder: &Folder, log: &str, rate: &[&str], more: &[&str]) -> Value {
    let mut arguments = vec!["explain-sensor", log, "--angle", "encoder_deg", "--json"];
    arguments.extend(rate);
    arguments.extend(more);
    let output = folder.program(&arguments).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

fn kinds(report: &Value) -> Vec<&str> {
    let effects = report["effects"].as_array().unwrap();
    let kinds = effects.iter().map(|effect| effect["kind"].as_str());
    kinds.collect::<Option<_>>().unwrap()
}

fn parameter(report: &Value, kind: &str, name: &str) -> f64 {
    let effects = report["effects"].as_array().unwrap();
    let effect = effects.iter().find(|effect| effect["kind"] == kind);
    number(&effect.unwrap()["parameters"][name])
}

#[test]
fn the_test_stretch_of_both_real_files_is_predicted() {
    let folder = Folder::new();
    for (name, rate, before_deg, after_deg, delay_ms, scale) in [
        ("roll", &ROLL[..], 146.6, 0.32, 6.1, 1.011),
        ("yaw", &YAW[..], 24.8, 1.10, 12.1, 0.989),
    ] {
        let found = report(&folder, &real(name), rate, &[]);
        assert_eq!(found["schema"], "mlr.sensor_explanation/1");
        let before = number(&found["error_before"]["validation_deg"]);
        assert!((before - before_deg).abs() < 0.1, "{name}: {before}");
        let after = number(&found["error_after"]["validation_deg"]);
        assert!((after - after_deg).abs() < 0.02, "{name}: {after}");
        for kind in ["gyro_bias", "gyro_scale", "sensor_delay"] {
            assert!(kinds(&found).contains(&kind), "{name}: {found}");
        }
        let delay_s = parameter(&found, "sensor_delay", "delay_s");
        assert!((1e3 * delay_s - delay_ms).abs() < 0.1, "{name}: {delay_s}");
        let found_scale = parameter(&found, "gyro_scale", "scale");
        assert!((found_scale - scale).abs() < 1e-3, "{name}: {found_scale}");
    }
}

/// What people do about a gyroscope without looking for effects: a bias, a linear calibration, an
/// orientation filter.
#[test]
fn the_explanation_is_better_than_every_baseline() {
    let folder = Folder::new();
    for (name, rate, best, best_deg) in [
        ("roll", &ROLL[..], "vqf", 0.557),
        ("yaw", &YAW[..], "bias_and_scale", 1.568),
    ] {
        let found = report(&folder, &real(name), rate, &[]);
        let baselines = found["baselines"].as_array().unwrap();
        let error = |baseline: &Value| number(&baseline["validation_deg"]);
        let least = baselines
            .iter()
            .min_by(|a, b| error(a).total_cmp(&error(b)));
        let least = least.unwrap();
        assert_eq!(least["name"], best, "{name}: {baselines:?}");
        assert!((error(least) - best_deg).abs() < 0.02, "{name}: {least}");
        let after = number(&found["error_after"]["validation_deg"]);
        assert!(after < 0.75 * error(least), "{name}: {after}");
        let data_sheet = &baselines[0];
        assert_eq!(data_sheet["name"], "data_sheet");
        for stretch in ["fit_deg", "validation_deg"] {
            assert_eq!(data_sheet[stretch], found["error_before"][stretch]);
        }
        // The motor never rests.
        assert!(baselines.iter().all(|b| b["name"] != "rest_bias"));
    }
}

#[test]
fn the_stretches_are_told_in_the_time_of_the_log() {
    let folder = Folder::new();
    let found = report(&folder, &real("roll"), &ROLL, &[]);
    for (stretch, expected_s) in [
        ("fit", [12.109, 132.107]),
        ("selection", [132.107, 222.106]),
        ("test", [222.106, 312.104]),
    ] {
        let borders_s = found["stretches_s"][stretch].as_array().unwrap();
        for (border_s, expected_s) in borders_s.iter().zip(expected_s) {
            assert!(
                (number(border_s) - expected_s).abs() < 1e-3,
                "{borders_s:?}"
            );
        }
    }
}

/// No effect makes the rate of another axis, or of another sign, that of the shaft.
#[test]
fn control_another_rate_is_not_explained() {
    let folder = Folder::new();
    for rate in [["--rate", "g2y_dps"], ["--rate", "g2z_dps"]] {
        let found = report(&folder, &real("yaw"), &rate, &[]);
        assert!(number(&found["error_after"]["validation_deg"]) > 30.0);
        assert_eq!(found["unexplained"], true);
    }
}

#[test]
fn the_drift_of_the_level_shaft_is_seen_by_gravity_only() {
    let folder = Folder::new();
    let with = report(&folder, &real("roll"), &ROLL, &[]);
    let without = report(
        &folder,
        &real("roll"),
        &ROLL,
        &["--without", "gravity_reference"],
    );
    assert!(kinds(&with).contains(&"gravity_reference"));
    assert!(!kinds(&without).contains(&"gravity_reference"));
    let error = |report: &Value| number(&report["error_after"]["validation_deg"]);
    assert!(error(&with) < 0.5 * error(&without));
    // The yaw shaft stands upright.
    let yaw = report(&folder, &real("yaw"), &YAW, &[]);
    let candidates = yaw["candidates"].as_array().unwrap();
    let gravity = candidates
        .iter()
        .find(|candidate| candidate["kind"] == "gravity_reference")
        .unwrap();
    let verdict = gravity["verdict"].as_str().unwrap();
    assert!(verdict.starts_with("not applicable"), "{verdict}");
}

#[test]
fn effects_are_carried_over_to_another_log() {
    let folder = Folder::new();
    let yaw = report(&folder, &real("yaw"), &YAW, &[]);
    let file = folder.write("yaw.json", yaw.to_string());
    // To the file they came from: the error is that of the explanation.
    let same = report(&folder, &real("yaw"), &YAW, &["--apply", &file]);
    let shares = [
        (0.4, "fit_deg"),
        (0.3, "selection_deg"),
        (0.3, "validation_deg"),
    ];
    let squares = shares.map(|(share, name)| share * number(&yaw["error_after"][name]).powi(2));
    let whole = squares.iter().sum::<f64>().sqrt();
    let applied = number(&same["transfer"]["error_after_deg"]);
    assert!((applied - whole).abs() < 0.01, "{applied} {whole}");
    // To the other axis: another bias, but the same delay.
    let other = report(&folder, &real("roll"), &ROLL, &["--apply", &file]);
    let effects = other["transfer"]["effects"].as_array().unwrap();
    let verdict = |kind: &str| {
        let effect = effects.iter().find(|effect| effect["kind"] == kind);
        effect.unwrap()["verdict"].as_str().unwrap()
    };
    assert!(verdict("sensor_delay").ends_with("helps within blocks"));
    assert!(number(&other["transfer"]["error_after_deg"]) > 10.0);
}

#[test]
fn the_table_is_for_people_and_repeats_itself() {
    let folder = Folder::new();
    let log = real("yaw");
    let arguments = [
        &["explain-sensor", &log, "--angle", "encoder_deg"][..],
        &YAW,
    ]
    .concat();
    let table = || folder.program(&arguments).output().unwrap().stdout;
    let text = String::from_utf8(table()).unwrap();
    for part in ["data_sheet", "vqf", "gyro_bias: z_dps -0.09", "unexplained"] {
        assert!(text.contains(part), "{text}");
    }
    assert_eq!(text.as_bytes(), table());
}

#[test]
fn wrong_usage_and_bad_input_are_named() {
    let folder = Folder::new();
    let bad = folder.write("bad.csv", "t_s,g_dps,a_deg\n0,1,2\n0.01,fast,2\n");
    let fails = |arguments: &[&str], message: &[&str]| {
        let all = [&["explain-sensor"][..], arguments].concat();
        folder.fails(&all, 2, message);
    };
    let both = ["--rate", "g_dps", "--angle", "a_deg"];
    fails(
        &[&[bad.as_str()][..], &both].concat(),
        &["bad.csv", "line 3", "g_dps", "fast"],
    );
    fails(
        &[&bad, "--rate", "gyro", "--angle", "a_deg"],
        &["bad.csv", "line 1", "gyro"],
    );
    fails(
        &[&bad, "--rate", "g_dps,rpm", "--angle", "a_deg"],
        &["--rate", "rpm", "dps, radps"],
    );
    fails(
        &["none.csv", "--rate", "g_dps", "--angle", "a_deg"],
        &["none.csv"],
    );
    let file = folder.write(
        "report.json",
        "{\"schema\": \"mlr.explanation/1\", \"effects\": []}",
    );
    fails(
        &[&[bad.as_str(), "--apply", &file][..], &both].concat(),
        &[
            "report.json",
            "mlr.explanation/1",
            "mlr.sensor_explanation/1",
        ],
    );
    fails(
        &[
            &[real("yaw").as_str(), "--without", "magic"][..],
            &YAW,
            &["--angle", "encoder_deg"],
        ]
        .concat(),
        &["magic", "gyro_bias"],
    );
}

#[test]
fn logs_that_cannot_answer_are_told_from_bad_ones() {
    let folder = Folder::new();
    let mut text = String::from("t_s,g_dps,a_deg\n");
    for i in 0..6000 {
        text += &format!("{},0,0\n", f64::from(i) * 0.01);
    }
    let still = folder.write("still.csv", &text);
    let short = folder.write(
        "short.csv",
        text.split_inclusive('\n').take(50).collect::<String>(),
    );
    for (log, message) in [(&still, "no motion"), (&short, "too short")] {
        folder.fails(
            &["explain-sensor", log, "--rate", "g_dps", "--angle", "a_deg"],
            1,
            &[message],
        );
    }
}
