use std::time::Duration;

use serde::Serialize;

use super::{Identification, IdentifiedLog};

/// Version of the JSON form.
const SCHEMA: &str = "mlr.identification/1";

/// An answer with all that is needed to get it again: the object that other
/// programs read.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct IdentificationReport {
    /// Name and version of the form.
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA)))]
    schema: &'static str,
    /// Where the recording came from: a file, or a port. Of several, the first.
    pub log: String,
    /// Of several recordings each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub logs: Vec<LogReport>,
    /// The answer.
    #[serde(flatten)]
    pub identification: Identification,
    /// Time that it took.
    pub elapsed_s: f64,
}

/// One of several recordings, with where it came from.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LogReport {
    /// The file.
    pub file: String,
    /// What it says of the best morphology.
    #[serde(flatten)]
    pub log: IdentifiedLog,
}

impl IdentificationReport {
    /// The report of an identification from one recording.
    pub fn new(log: String, identification: Identification, elapsed: Duration) -> Self {
        Self {
            schema: SCHEMA,
            log,
            logs: Vec::new(),
            identification,
            elapsed_s: elapsed.as_secs_f64(),
        }
    }

    /// The report of an identification from recordings of these names, in their order.
    pub fn of_files(files: Vec<String>, identification: Identification, elapsed: Duration) -> Self {
        let first = files.first().cloned().unwrap_or_default();
        let logs = match files.len() {
            1 => Vec::new(),
            _ => {
                let each = files.into_iter().zip(&identification.logs);
                each.map(|(file, log)| LogReport {
                    file,
                    log: log.clone(),
                })
                .collect()
            }
        };
        Self {
            logs,
            ..Self::new(first, identification, elapsed)
        }
    }
}
