//! What the daemon prints and reads, against the JSON Schemas that are kept of it. Those of `mlr-ga` are checked
//! beside its command line.
//!
//! ```text
//! MLR_RECORD_GOLDEN=1 cargo test -p mlr-golden-tests --test schemas
//! ```
//! writes them anew.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::{fs, path::PathBuf, time::SystemTime};

use mlr_model::Robot;
use mlrd::{
    Options, Settings,
    event::{Event, Kind, Status, WatchedRobot, line},
};
use schemars::{JsonSchema, generate::SchemaSettings};
use serde_json::Value;

#[path = "../crates/mlr-ga/tests/cli/schema_check.rs"]
mod schema_check;

fn file(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../docs/schemas");
    folder.join(format!("{name}.schema.json"))
}

/// The schema of a type, which must be the one that is kept.
fn kept<T: JsonSchema>(name: &str, contract: fn(SchemaSettings) -> SchemaSettings) -> Value {
    let settings = contract(SchemaSettings::draft2020_12());
    let mut schema = settings.into_generator().into_root_schema_for::<T>();
    schema.insert("title".into(), name.into());
    let text = serde_json::to_string_pretty(&schema).unwrap() + "\n";
    if std::env::var_os("MLR_RECORD_GOLDEN").is_some() {
        fs::write(file(name), &text).unwrap();
    }
    assert!(
        fs::read_to_string(file(name)).unwrap() == text,
        "{name}: the type has changed; MLR_RECORD_GOLDEN=1 writes its schema anew"
    );
    serde_json::from_str(&text).unwrap()
}

#[test]
fn events_keep_to_their_schema() {
    let schema = kept::<Event<'static>>("mlrd-event", SchemaSettings::for_serialize);
    let status = Status {
        good: 7,
        bad: 0,
        lost: 0,
        state: "standing",
        fault: None,
        silent_s: 0.25,
        rate_hz: Some(500.0),
        roll_deg: None,
        pitch_deg: Some(-0.5),
        fluctuation_deg: Some(0.4),
        fluctuations_deg: vec![0.5, 0.4],
        threshold_deg: 5.0,
        dropped_status: 0,
        dropped_events: 0,
    };
    for kind in [
        Kind::Started {
            port: "/dev/ttyTHS1".into(),
            robot: WatchedRobot::new(&Robot::jethexa()),
            last_known: None,
            calibration: None,
        },
        Kind::PortLost {
            reason: "unplugged".into(),
        },
        Kind::SensorFault {
            fault: "frozen",
            reason: "the same sample again and again".into(),
            since_s: 2.5,
        },
        Kind::MotionStarted {
            motion_start_s: 6.05,
        },
        Kind::DamageDetected {
            fluctuation_deg: 12.4,
            changed: false,
        },
        Kind::Recovered,
        Kind::Status(Box::new(status)),
        Kind::Stopped,
    ] {
        let line = line(SystemTime::UNIX_EPOCH, 2.5, &kind).unwrap();
        let mut event: Value = serde_json::from_str(&line).unwrap();
        assert_eq!(schema_check::check(&schema, &event), Ok(()), "{line}");
        event["event"] = "exploded".into();
        assert!(schema_check::check(&schema, &event).is_err(), "{event}");
    }
}

#[test]
fn the_settings_that_are_printed_load_again_and_name_every_key() {
    let schema = kept::<Settings>("mlrd-config", SchemaSettings::for_deserialize);
    let printed = |arguments: &[&str]| {
        let arguments = ["mlrd", "--print-config"].iter().chain(arguments);
        let options = <Options as clap::Parser>::try_parse_from(arguments).unwrap();
        options.printed().unwrap().unwrap()
    };
    let text = printed(&[]);
    let read = Settings::checked_from_toml(&text, None).unwrap();
    assert_eq!(read, Settings::default());
    for key in schema["properties"].as_object().unwrap().keys() {
        let is_there = text.lines().any(|line| {
            let line = line.trim_start_matches("# ");
            line.starts_with(&format!("{key} =")) || line.starts_with(&format!("[{key}"))
        });
        assert!(is_there, "{key} is not in:\n{text}");
    }
    assert!(
        text.contains("# Speed of the port.\nbaud = 115200\n"),
        "{text}"
    );
    // What is chosen stands in the place of its default.
    let chosen = printed(&["--port", "/dev/ttyTHS1", "--baud", "9600"]);
    assert!(chosen.contains("\nport = \"/dev/ttyTHS1\"\n") && chosen.contains("\nbaud = 9600\n"));
    let page = <Options as clap::Parser>::try_parse_from(["mlrd", "--generate", "man"]).unwrap();
    let page = page.printed().unwrap().unwrap();
    assert!(
        page.contains(".TH mlrd") && page.contains("print"),
        "{page}"
    );
    for shell in ["complete-bash", "complete-zsh", "complete-fish"] {
        let script =
            <Options as clap::Parser>::try_parse_from(["mlrd", "--generate", shell]).unwrap();
        let script = script.printed().unwrap().unwrap();
        assert!(script.contains("state-dir"), "{shell}: {script}");
    }
}
