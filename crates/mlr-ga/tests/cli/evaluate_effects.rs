//! Explanations of a directory of logs against the truth, as far as no walk is needed for it.

use std::{fs, path::Path};

use assert_cmd::Command;
use serde_json::{Value, json};

/// Two logs that are too short to answer: one with a visible effect, one without any.
fn too_short_logs(folder: &Path) {
    let healthy = "[[1,1,1],[1,1,1],[1,1,1],[1,1,1],[1,1,1],[1,1,1]]";
    let trace = r#"{"mean_deg": [0, 0, 0], "swing_deg": [1, 0, 0]}"#;
    let truth = format!(
        r#"{{"a": {{"morphology": {healthy}, "effects": [{{"kind": "payload"}}], "trace": {trace}}},
             "b": {{"morphology": {healthy}, "effects": []}}}}"#
    );
    fs::write(folder.join("truth.json"), truth).unwrap();
    for name in ["a.csv", "b.csv"] {
        let log = "t_s,roll_rad,pitch_rad,yaw_rad\n0,0,0,0\n0.01,0,0,0\n0.02,0,0,0\n";
        fs::write(folder.join(name), log).unwrap();
    }
}

/// Standard output and error, and the exit status.
fn evaluate(folder: &Path, options: &[&str]) -> (String, String, i32) {
    let mut program = Command::new(assert_cmd::cargo::cargo_bin!("mlr-ga"));
    let run = program.arg("evaluate-effects").arg(folder).args(options);
    let output = run.output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    (
        text(&output.stdout),
        text(&output.stderr),
        output.status.code().unwrap(),
    )
}

#[test]
fn logs_without_an_answer_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    too_short_logs(folder.path());
    let (json, _, status) = evaluate(folder.path(), &["--json"]);
    assert_eq!(status, 0);
    let report: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(report["schema"], "mlr.effects-evaluation/2");
    assert_eq!(report["logs"].as_array().unwrap().len(), 0);
    assert_eq!(report["unanswered"][0]["log"], "a");
    assert_eq!(report["totals"][0]["origin"], "drawn");
    let classes = report["totals"][0]["classes"].as_array().unwrap();
    let of =
        |field: &str| -> Vec<Value> { classes.iter().map(|class| class[field].clone()).collect() };
    assert_eq!(of("class"), ["visible", "undisturbed"]);
    assert_eq!(of("logs"), [1, 1]);
    assert_eq!(of("unanswered"), [1, 1]);
    let (table, _, _) = evaluate(folder.path(), &["--only", "b"]);
    assert!(table.contains("| b ") && !table.contains("| a "), "{table}");
    assert!(table.contains("no answer: "), "{table}");
}

#[test]
fn a_run_that_was_interrupted_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    too_short_logs(folder.path());
    let file = folder.path().join("results.jsonl");
    let resume = ["--resume", file.to_str().unwrap()];
    let kept = || fs::read_to_string(&file).unwrap();
    // As if the run had ended after the first log.
    let (_, _, status) = evaluate(folder.path(), &[&resume[..], &["--only", "a"]].concat());
    assert_eq!((status, kept().lines().count()), (0, 2));
    // A result that no run would make shows that it was taken from the file.
    fs::write(
        &file,
        kept().replace("\"reason\":\"", "\"reason\":\"kept: "),
    )
    .unwrap();
    let (table, _, status) = evaluate(folder.path(), &resume);
    assert_eq!((status, kept().lines().count()), (0, 3));
    assert_eq!(table.matches("no answer: kept: ").count(), 1, "{table}");
    assert_eq!(table.matches("no answer: ").count(), 2, "{table}");
    let whole = kept();
    assert_eq!(evaluate(folder.path(), &resume).0, table);
    assert_eq!(kept(), whole);

    let other_seed = [&resume[..], &["--seed", "2"]].concat();
    let (_, error, status) = evaluate(folder.path(), &other_seed);
    assert_eq!(status, 2);
    assert!(error.contains("results.jsonl: line 1"), "{error}");
    assert!(error.contains("(seed: 1; this one: 2)"), "{error}");

    let log = fs::read_to_string(folder.path().join("b.csv")).unwrap();
    fs::write(folder.path().join("b.csv"), log + "0.03,0,0,0\n").unwrap();
    let (_, error, status) = evaluate(folder.path(), &resume);
    assert_eq!(status, 2);
    assert!(
        error.contains("b: the log or its truth has changed"),
        "{error}"
    );
    assert_eq!(kept(), whole);
}

/// A score in place of the one that a run kept of log `a`.
fn keep_a_score(file: &Path, places: &Value) {
    let statement = |kind: &str, probability: f64, is_true: bool| json!({"kind": kind, "probability": probability, "is_true": is_true});
    let errors = |deg: f64| json!({"fit_deg": deg, "validation_deg": 2.0 * deg});
    let score = json!({
        "log": "a", "origin": "drawn", "class": "visible", "visibility": "stands_out",
        "truth": [{"kind": "weak_leg", "parameters": {"leg": 3, "gain": 0.5}}],
        "found": [{"kind": "weak_leg", "parameters": {"leg": 3, "gain": 0.4}, "probability": 0.81}],
        "unexplained": false, "verdict": "right", "verdict_but_for_mark": "right", "places": places,
        "kinds": {
            "statements": [
                statement("friction", 0.001, false),
                statement("payload", 0.189, false),
                statement("weak_leg", 0.81, true),
            ],
            "ln_probability": 0.81_f64.ln(), "brier": 0.07,
            "credible": ["payload", "weak_leg"], "credible_holds_truth": true,
            "sure": [], "sure_is_true": true,
        },
        "error_before": errors(4.0), "error_calibrated": errors(2.0), "error_after": errors(0.5),
        "legs_right_before": false, "legs_right": true, "links_right": true, "elapsed_s": 12.0,
    });
    let text = fs::read_to_string(file).unwrap();
    let lines = text.lines().map(|line| {
        let mut line: Value = serde_json::from_str(line).unwrap();
        if line["log"] == "a" {
            line["result"]["outcome"] = json!({ "scored": score });
        }
        format!("{line}\n")
    });
    let lines: String = lines.collect();
    fs::write(file, lines).unwrap();
}

#[test]
fn the_table_tells_kind_and_place_apart() {
    let folder = tempfile::tempdir().unwrap();
    too_short_logs(folder.path());
    let file = folder.path().join("results.jsonl");
    let resume = ["--resume", file.to_str().unwrap()];
    evaluate(folder.path(), &resume);
    let table = |leg_right: bool| {
        let place = json!([{"kind_found": true, "leg_right": leg_right, "place_right": leg_right}]);
        keep_a_score(&file, &place);
        evaluate(folder.path(), &resume).0
    };
    let right = table(true);
    for words in [
        "| weak_leg gain 0.500, leg 3 ",
        "| weak_leg gain 0.400, leg 3 ",
        "| weak_leg 81 %, payload 19 % ",
        "| right ",
        "| 4.00 → 2.00 → 0.50 | 8.00 → 4.00 → 1.00 |",
        "| WRONG → right |",
        "1: kind found 1, of these on the right leg 1, and on the right link or joint 1",
        "2 logs: right 0 before, 1 after; right before but wrong after 0, the other way 1",
        "|            80 to 90 % |          1 | 81.0 % |    1 | 100.0 % |",
    ] {
        assert!(right.contains(words), "{words} in\n{right}");
    }
    let other_leg = table(false);
    assert!(other_leg.contains("| right, other place |"), "{other_leg}");
    assert!(
        other_leg.contains("of these on the right leg 0"),
        "{other_leg}"
    );
}
