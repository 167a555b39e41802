use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use mlr_imu::read_text;
use mlr_model::{LegLayout, Morphology};
use serde::Deserialize;
use thiserror::Error;

/// What was done to the robot that made a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Name of the log, without `.csv` or `.csv.gz`.
    pub name: String,
    /// The log.
    pub log: PathBuf,
    /// What was left of the robot.
    pub morphology: Morphology,
}

/// A `truth.json` that cannot be used.
#[derive(Debug, Error)]
#[error("{}: {problem}", path.display())]
pub struct TruthError {
    /// The file, or the log it speaks of.
    pub path: PathBuf,
    /// What is wrong.
    pub problem: String,
}

#[derive(Deserialize)]
struct Entry {
    morphology: Morphology,
}

/// Name of the file that says what was done to the robot of each log.
pub(super) const FILE: &str = "truth.json";
/// The most that is read of it: some ten thousand logs.
pub(super) const MAX_BYTES: u64 = 50_000_000;

/// Reads a directory's `truth.json`: one object per log, with at least its
/// `morphology`.
///
/// # Errors
/// [`TruthError`] names the file and the entry at fault.
pub fn read_truths(directory: &Path, layout: &LegLayout) -> Result<Vec<Truth>, TruthError> {
    let path = directory.join(FILE);
    let fail = |problem: String| TruthError {
        path: path.clone(),
        problem,
    };
    let text = read_text(&path, MAX_BYTES).map_err(|error| fail(error.to_string()))?;
    let entries: BTreeMap<String, Entry> =
        serde_json::from_str(&text).map_err(|error| fail(error.to_string()))?;
    entries
        .into_iter()
        .map(|(name, entry)| {
            let log = [".csv.gz", ".csv"]
                .map(|suffix| directory.join(format!("{name}{suffix}")))
                .into_iter()
                .find(|log| log.exists())
                .ok_or_else(|| fail(format!("{name}: there is no log of this name")))?;
            let morphology = entry.morphology;
            if morphology.layout() != *layout {
                let healthy = Morphology::healthy(layout);
                return Err(fail(format!(
                    "{name}: morphology: {morphology} is not of this robot, expected legs and links as in {healthy}"
                )));
            }
            Ok(Truth {
                name,
                log,
                morphology,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn faults_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let layout = LegLayout::new([1, 1]).unwrap();
        let read = |text: &str| {
            fs::write(folder.path().join(FILE), text).unwrap();
            read_truths(folder.path(), &layout)
        };
        fs::write(folder.path().join("a.csv"), "").unwrap();
        let truths = read(r#"{"a": {"morphology": [[1], [0]], "locked": true}}"#).unwrap();
        assert_eq!(truths[0].morphology.damaged_legs(), [2]);
        for (text, told) in [
            (r#"{"b": {"morphology": [[1], [0]]}}"#, "b: there is no log"),
            (r#"{"a": {"morphology": [[1]]}}"#, "a: morphology: 1 is not"),
            (
                r#"{"a": {"morphology": [[1, 1]]}}"#,
                "expected legs and links as in 1 1",
            ),
            (r#"{"a": {"morphology": [[1], [2]]}}"#, "expected 0 or 1"),
            (r#"{"a": {}}"#, "morphology"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains(told) && error.contains(FILE), "{error}");
        }
    }
}
