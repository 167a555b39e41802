use std::time::Duration;

use serde::Serialize;

use super::Identification;

/// Version of the JSON form.
const SCHEMA: &str = "mlr.identification/1";

/// An answer with all that is needed to get it again: the object that other
/// programs read.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct IdentificationReport {
    /// Name and version of the form.
    schema: &'static str,
    /// Where the recording came from: a file, or a port.
    pub log: String,
    /// The answer.
    #[serde(flatten)]
    pub identification: Identification,
    /// Time that it took.
    pub elapsed_s: f64,
}

impl IdentificationReport {
    /// The report of an identification.
    pub fn new(log: String, identification: Identification, elapsed: Duration) -> Self {
        Self {
            schema: SCHEMA,
            log,
            identification,
            elapsed_s: elapsed.as_secs_f64(),
        }
    }
}
