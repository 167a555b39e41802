//! `mlr-ga report`: pages of stand-in logs, made of answers that were saved.

use std::fs;

use serde_json::Value;

use super::{
    in_browser::{Browser, Screen},
    program::Folder,
};

const LOG: &str = "../../data/logs/stand-in/legs2-3-lost.csv.gz";
const ANSWER: &str = "../mlr-report/tests/answers/legs2-3-lost.identification.json";
const OTHER_LOG: &str = "../../data/logs/stand-in/undeclared-c.csv.gz";
const OTHER_ANSWER: &str = "../mlr-report/tests/answers/undeclared-c.identification.json";
const EXPLANATION: &str = "../mlr-report/tests/answers/undeclared-c.explanation.json";

/// The least PNG.
const PNG: [u8; 8] = [0x89, b'P', b'N', b'G', 0x0d, 0x0a, 0x1a, 0x0a];

#[test]
fn a_saved_answer_becomes_a_page_and_plots() {
    let folder = Folder::new();
    let page = folder.path("report.html");
    let plots = folder.path("plots");
    let gait = folder.write("gait.toml", mlr_model::Gait::TRIPOD_TOML);
    let arguments = [
        "report",
        OTHER_LOG,
        "--answer",
        OTHER_ANSWER,
        "--explanation",
        EXPLANATION,
        "--recovery",
        &gait,
        "-o",
        &page,
        "--plots",
        &plots,
        "--json",
    ];
    let report: Value = serde_json::from_str(&folder.succeeds(&arguments)).unwrap();
    assert_eq!(report["schema"], "mlr.report/1");
    assert_eq!(report["not_computed"], serde_json::json!([]));
    let html = fs::read_to_string(&page).unwrap();
    assert_eq!(report["bytes"], html.len());
    assert!(html.len() < 2_000_000, "{} bytes", html.len());
    for shown in [
        "No leg is damaged",
        "Besides: IMU misalignment",
        "Footfalls",
        "undeclared-c.csv.gz",
        // As sha256sum has it.
        SHA256_OF_OTHER_LOG,
    ] {
        assert!(html.contains(shown), "{shown}");
    }
    let files = report["plots"].as_array().unwrap();
    assert_eq!(files.len(), 16);
    for file in files.iter().filter_map(Value::as_str) {
        let content = fs::read(file).unwrap();
        match file.ends_with(".png") {
            true => assert_eq!(content[..8], PNG, "{file}"),
            false => assert!(content.starts_with(b"<svg "), "{file}"),
        }
    }
    // What is there is not overwritten.
    folder.fails(&arguments, 2, &["report.html", "not overwritten"]);
    let elsewhere = folder.path("other.html");
    let arguments = [
        "report", LOG, "--answer", ANSWER, "-o", &elsewhere, "--plots", &plots,
    ];
    folder.fails(&arguments, 2, &["plots: is not empty"]);
    assert!(!fs::exists(&elsewhere).unwrap());
}

const SHA256_OF_OTHER_LOG: &str =
    "39dd5b4924ac4a861fd90a10a5d577a09983de086b98cb87053a4ca05c24d28c";

#[test]
fn a_hostile_name_does_no_harm_and_the_page_is_sound_in_a_browser() {
    let folder = Folder::new();
    let log = folder.write(
        "<script>alert(1)<\u{202e}img>.csv.gz",
        fs::read(LOG).unwrap(),
    );
    let page = folder.path("report.html");
    let told = folder.succeeds(&["report", &log, "--answer", ANSWER, "-o", &page]);
    assert!(told.contains("not computed"), "{told}");
    let html = fs::read_to_string(&page).unwrap();
    assert!(!html.contains("<script"));
    assert!(html.contains("alert(1)"));
    assert!(!html.contains('\u{202e}'));
    let Some(browser) = Browser::found() else {
        return;
    };
    for (width, screen) in [(390, Screen::Light), (1280, Screen::Dark)] {
        let seen = browser.open(&page, width, screen);
        assert_eq!(seen.errors, Vec::<String>::new());
        assert!(
            seen.content_width <= f64::from(width),
            "{} wide in {width}",
            seen.content_width
        );
        assert_eq!(seen.unnamed_pictures, 0);
        assert_eq!(seen.pictures, 6);
        assert!(seen.texts > 100, "{seen:?}");
        let (contrast, text) = (seen.least_contrast, &seen.least_contrast_text);
        assert!(contrast >= 4.5, "{text}: {contrast}");
    }
}

/// The screenshots of `docs/report.md`; `UPDATE_DOCS=1 cargo test -p mlr-ga --test cli screenshots` takes them
/// anew.
#[test]
fn screenshots_show_the_page_on_a_desktop_and_on_a_phone() {
    let Some(browser) = Browser::found() else {
        return;
    };
    let folder = Folder::new();
    let page = folder.path("report.html");
    folder.succeeds(&["report", LOG, "--answer", ANSWER, "-o", &page]);
    for (name, size, screen) in [
        ("report-desktop.png", [1000, 1500], Screen::Light),
        ("report-phone.png", [390, 1700], Screen::Dark),
    ] {
        let picture = browser.screenshot(&page, size, screen);
        assert_eq!(picture[..8], PNG);
        let number = |at: usize| u32::from_be_bytes(picture[at..at + 4].try_into().unwrap());
        assert_eq!([number(16), number(20)], size, "{name}");
        // An empty page of this size has 10 kB.
        assert!(picture.len() > 50_000, "{name}: {} bytes", picture.len());
        if std::env::var_os("UPDATE_DOCS").is_some() {
            fs::write(format!("../../docs/{name}"), &picture).unwrap();
        }
    }
}

#[test]
fn an_answer_to_something_else_is_refused() {
    let folder = Folder::new();
    let page = folder.path("report.html");
    let fails = |log: &str, more: &[&str], message: &[&str]| {
        let mut arguments = vec!["report", log, "-o", &page];
        arguments.extend(more);
        folder.fails(&arguments, 2, message);
        assert!(!fs::exists(&page).unwrap());
    };
    let answer = |path| ["--answer", path];
    // Of another log.
    fails(
        LOG,
        &answer(OTHER_ANSWER),
        &["undeclared-c.identification.json", "name the same logs"],
    );
    // To another question.
    fails(
        OTHER_LOG,
        &answer(EXPLANATION),
        &["one of explain, expected one of identify"],
    );
    let explanation = ["--answer", OTHER_ANSWER, "--explanation", ANSWER];
    fails(OTHER_LOG, &explanation, &["expected one of explain"]);
    // Of another robot.
    let octopod = [
        "--answer",
        ANSWER,
        "--robot",
        "../../data/robot/octopod.toml",
        "--gait",
        "../../data/gait/octopod.toml",
    ];
    fails(LOG, &octopod, &["name the --robot"]);
    let broken = folder.write("broken.json", "{\"schema\":\"mlr.identification/1\"}");
    fails(LOG, &answer(&broken), &["broken.json", "morphology"]);
    // An answer needs no search.
    let both = ["--answer", ANSWER, "--search", "exact"];
    fails(LOG, &both, &["--search", "--answer"]);
}
