//! The answers that a page shows, as other programs read them: the fields of
//! `mlr.identification/1` and `mlr.explanation/1`.

mod explanation;
mod identification;

pub use explanation::{
    AxisResidual, Candidate, Effect, Errors, Explanation, Harmonic, Hypothesis, Remaining,
    Residuals, Rival, Stretches, Value,
};
pub use identification::{Alternative, Finding, Fit, Identification, LogQuality, OneLog, Severity};
