use std::time::Duration;

use mlr_imu::quality::LogQuality;
use mlr_residual::walk::WalkExplanation;
use serde::Serialize;

use super::Explained;

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
    /// Log times of the walk before damage in mid-walk that the robot is known by.
    pub calibrated_on_s: Option<[f64; 2]>,
    /// What the recording says about itself.
    pub log_quality: LogQuality,
    /// Time that it took.
    pub elapsed_s: f64,
}

impl ExplanationReport {
    /// The report of what [`explain`](super::explain) found.
    pub fn of(log: String, seed: u64, explained: Explained, elapsed: Duration) -> Self {
        let quality = explained.identification.log_quality;
        Self {
            calibrated_on_s: explained.calibrated_on_s,
            ..Self::new(log, seed, explained.explanation, quality, elapsed)
        }
    }

    /// The report of an explanation of a robot known as described.
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
            calibrated_on_s: None,
            log_quality,
            elapsed_s: elapsed.as_secs_f64(),
        }
    }
}
