//! Runs the program on files in a folder of its own.

use std::{f64::consts::TAU, fmt::Write, fs};

use assert_cmd::{Command, cargo::cargo_bin_cmd};
use tempfile::TempDir;

use crate::schema_check;

pub(crate) const HEADER: &str = "t_s,roll_rad,pitch_rad,yaw_rad\n";

pub(crate) struct Folder(TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> String {
        self.0.path().join(name).display().to_string()
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) -> String {
        let path = self.path(name);
        fs::write(&path, content).unwrap();
        path
    }

    pub(crate) fn program(&self, arguments: &[&str]) -> Command {
        let mut command = cargo_bin_cmd!("mlr-ga");
        command.args(arguments);
        command
    }

    /// The program must fail with this status, say all of this on stderr without
    /// panicking, and print nothing on stdout.
    #[allow(dead_code, reason = "not every test file has a failure to check")]
    pub(crate) fn fails(&self, arguments: &[&str], status: i32, message_has: &[&str]) {
        let output = self.program(arguments).output().unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(status), "{message}");
        for part in message_has {
            assert!(message.contains(part), "{part:?} is not in: {message}");
        }
        assert!(!message.contains("panicked"), "{message}");
        assert!(output.stdout.is_empty(), "no partial result");
    }

    /// Stdout of the program, which must succeed.
    #[allow(dead_code, reason = "not every test file has a success to check")]
    pub(crate) fn succeeds(&self, arguments: &[&str]) -> String {
        let output = self.program(arguments).output().unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{message}");
        assert_eq!(message, "", "no progress bar without a terminal");
        let text = String::from_utf8(output.stdout).unwrap();
        keeps_to_its_schema(&text);
        text
    }
}

/// What names its schema must keep to it.
fn keeps_to_its_schema(text: &str) {
    let Ok(value) = serde_json::from_str::<serde_json::Value>(text) else {
        return;
    };
    let Some(name) = value["schema"]
        .as_str()
        .and_then(|name| name.strip_prefix("mlr."))
    else {
        return;
    };
    let name = name.split('/').next().unwrap().replace('_', "-");
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/schemas");
    let schema = fs::read_to_string(folder.join(format!("{name}.schema.json"))).unwrap();
    let schema = serde_json::from_str(&schema).unwrap();
    if let Err(difference) = schema_check::check(&schema, &value) {
        panic!("mlr-ga schema {name}: {difference}");
    }
}

/// A log of a body that is still until `stand_s` and rolls by 8° from then on.
#[allow(dead_code, reason = "not every test file needs a made-up log")]
pub(crate) fn standing_then_rocking(stand_s: f64, end_s: f64, rate_hz: f64) -> String {
    let mut text = HEADER.to_string();
    for i in 0..(end_s * rate_hz) as usize {
        let t = i as f64 / rate_hz;
        let roll = 0.14 * (TAU * (t - stand_s).max(0.0)).sin();
        writeln!(text, "{t:.5},{roll:.6},0,0").unwrap();
    }
    text
}
