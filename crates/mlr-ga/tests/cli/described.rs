//! What the program says about itself: settings, schemas, completions, manual pages, version.

use std::fs;

use serde_json::Value;

use crate::program::Folder;

/// Every key of the settings, as in `identification.window_s`, with whether it is set by default.
fn keys_of_schema(root: &Value, schema: &Value, at: &str, keys: &mut Vec<String>) {
    let resolved = |schema: &Value| -> Value {
        let named = |schema: &Value| {
            Some(
                root.pointer(schema["$ref"].as_str()?.strip_prefix('#')?)?
                    .clone(),
            )
        };
        let present = schema["anyOf"]
            .as_array()
            .into_iter()
            .flatten()
            .find_map(named);
        named(schema).or(present).unwrap_or_else(|| schema.clone())
    };
    let schema = resolved(schema);
    for (key, property) in schema["properties"].as_object().into_iter().flatten() {
        let name = format!("{at}{key}");
        keys_of_schema(root, property, &format!("{name}."), keys);
        keys.push(name);
    }
}

#[test]
fn config_prints_every_key_and_loads_again_as_the_defaults() {
    let folder = Folder::new();
    let printed = folder.succeeds(&["config"]);
    let read = mlr_ga::Configuration::from_toml(&printed).unwrap();
    assert_eq!(read, mlr_ga::Configuration::default());
    let paper = folder.succeeds(&["config", "--method", "paper"]);
    let read = mlr_ga::Configuration::from_toml(&paper).unwrap();
    let preset = mlr_ga::IdentifySettings::of(mlr_ga::Method::Paper);
    assert_eq!(read.identification, preset);
    // Everything that can be set, with or without a default.
    let schema: Value = serde_json::from_str(&folder.succeeds(&["schema", "config"])).unwrap();
    let mut keys = Vec::new();
    keys_of_schema(&schema, &schema, "", &mut keys);
    for key in [
        "identification.window_s",
        "explanation.discrepancy",
        "recovery.robots",
    ] {
        assert!(
            keys.iter().any(|known| known == key),
            "{key} is not among {keys:?}"
        );
    }
    for key in &keys {
        let last = key.rsplit('.').next().unwrap();
        let is_there = printed.lines().any(|line| {
            let line = line.trim_start_matches("# ");
            line.starts_with(&format!("{last} =")) || line.trim_matches(['[', ']']) == key
                // A section of nothing but sections has no line of its own.
                || line.trim_start_matches('[').starts_with(&format!("{key}."))
        });
        assert!(is_there, "{key} is not in:\n{printed}");
    }
    // What they mean, from the doc comments.
    assert!(
        printed.contains("# Length of the compared stretch.\nwindow_s = 5.0\n"),
        "{printed}"
    );
    // As --config of another command.
    let file = folder.write("all.toml", &printed);
    folder.fails(&["detect", "none.csv", "--config", &file], 2, &["none.csv"]);
}

#[test]
fn schemas_are_listed_and_printed() {
    let folder = Folder::new();
    let names = folder.succeeds(&["schema"]);
    assert!(names.lines().count() > 15, "{names}");
    for name in names.lines() {
        let schema: Value = serde_json::from_str(&folder.succeeds(&["schema", name])).unwrap();
        assert_eq!(schema["title"], name);
    }
    folder.fails(&["schema", "identifcation"], 2, &["identification"]);
}

#[test]
fn completions_know_every_command() {
    let folder = Folder::new();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = folder.succeeds(&["completions", shell]);
        for word in ["identify", "evaluate-effects", "--most-damaged-legs"] {
            let bare = word.trim_start_matches('-');
            assert!(script.contains(bare), "{word} is not in that of {shell}");
        }
    }
}

#[test]
fn there_is_a_manual_page_for_each_command() {
    let folder = Folder::new();
    let pages = folder.path("man");
    folder.succeeds(&["man", &pages]);
    for name in ["mlr-ga.1", "mlr-ga-identify.1", "mlr-ga-atlas-build.1"] {
        let page = fs::read_to_string(format!("{pages}/{name}")).unwrap();
        assert!(
            page.contains(".TH ") && page.contains(".SH OPTIONS"),
            "{name}: {page}"
        );
    }
    folder.fails(&["man", &pages], 2, &["mlr-ga.1"]);
}

#[test]
fn notes_are_said_unless_told_to_be_quiet_and_more_when_asked() {
    let folder = Folder::new();
    let stderr = |level: &[&str]| {
        let arguments = [&["export", "--format", "urdf"], level].concat();
        let output = folder.program(&arguments).output().unwrap();
        assert!(output.status.success());
        String::from_utf8(output.stderr).unwrap()
    };
    let usual = stderr(&[]);
    assert!(usual.starts_with("mlr-ga: left out: "), "{usual}");
    assert_eq!(stderr(&["--quiet"]), "");
    let verbose = stderr(&["-v"]);
    assert!(
        verbose.contains(&usual) && verbose.contains("mlr-ga: version "),
        "{verbose}"
    );
    // What went wrong is said all the same.
    folder.fails(
        &["import", "-q", "none.urdf", "-o", "x.toml"],
        2,
        &["none.urdf"],
    );
}

#[test]
fn the_version_is_that_of_the_package() {
    let version = Folder::new().succeeds(&["--version"]);
    let expected = format!("mlr-ga {}", env!("CARGO_PKG_VERSION"));
    let commit = version.trim_end().strip_prefix(&expected).unwrap();
    assert!(
        commit.is_empty() || (commit.starts_with(" (") && commit.ends_with(')')),
        "{version}"
    );
}

#[test]
fn tables_have_no_colours_in_a_file_and_legs_have_names() {
    let folder = Folder::new();
    let log = folder.path("log.csv");
    folder.succeeds(&["simulate", "--legs-lost", "4", "--walk-s", "6", "-o", &log]);
    let table = folder.succeeds(&["compare", &log, "--legs-lost", "4"]);
    assert!(table.contains("leg 4 (middle right) lost"), "{table}");
    assert!(!table.contains('\u{1b}'), "{table:?}");
    let forced = folder
        .program(&["compare", &log, "--legs-lost", "4"])
        .env("CLICOLOR_FORCE", "1")
        .output()
        .unwrap();
    assert!(
        String::from_utf8(forced.stdout)
            .unwrap()
            .contains("\u{1b}[36mmorphology")
    );
}
