use std::time::Duration;

use mlr_imu::quality::LogQuality;
use mlr_residual::walk::WalkExplanation;
use serde::Serialize;

/// Version of the JSON form.
const SCHEMA: &str = "mlr.explanation/1";

/// An explanation with all that is needed to get it again: the object that other programs
/// read.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ExplanationReport {
    /// Name and version of the form.
    #[cfg_attr(feature = "schema", schemars(extend("const" = SCHEMA)))]
    schema: &'static str,
    /// Where the recording came from: a file, or a port.
    pub log: String,
    /// Seed of the search.
    pub seed: u64,
    /// What the model lacks.
    #[serde(flatten)]
    pub explanation: WalkExplanation,
    /// What the recording says about itself.
    pub log_quality: LogQuality,
    /// Time that it took.
    pub elapsed_s: f64,
}

impl ExplanationReport {
    /// The report of an explanation.
    pub fn new(
        log: String,
        seed: u64,
        explanation: WalkExplanation,
        log_quality: LogQuality,
        elapsed: Duration,
    ) -> Self {
        Self {
            schema: SCHEMA,
            log,
            seed,
            explanation,
            log_quality,
            elapsed_s: elapsed.as_secs_f64(),
        }
    }
}
