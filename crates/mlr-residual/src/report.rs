//! What an explanation says.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{
    SensorRecord, Stretches,
    fitted_model::BLOCKS,
    statistics::{BlockErrors, rms},
};

/// An effect that was added to the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Effect {
    /// Name of the effect.
    pub kind: String,
    /// Value of each parameter as fitted at last, on fit and selection stretch; the name ends
    /// in the unit.
    pub parameters: BTreeMap<String, f64>,
    /// 95 % interval of each parameter that the record determines.
    #[serde(default)]
    pub interval_95: BTreeMap<String, [f64; 2]>,
    /// Error with this effect and all before it, fitted on the fit stretch alone, as it was when
    /// the effect was added.
    #[serde(default)]
    pub error_deg: Option<ErrorDeg>,
    /// What it leaves in the residual.
    #[serde(default)]
    pub explains: String,
    /// Probability of a gain as large on the selection stretch, had the effect none (exact
    /// sign-flip test); see [`explain_sensor()`](crate::explain_sensor()).
    #[serde(default)]
    pub p_value: Option<f64>,
    /// Other accepted candidates that it did not differ from significantly when it was added.
    #[serde(default)]
    pub rivals: Vec<String>,
}

/// Root mean square errors on the stretches of a record ([`Stretches`]), degrees.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ErrorDeg {
    /// On the fit stretch.
    pub fit_deg: f64,
    /// On the selection stretch.
    pub selection_deg: f64,
    /// On the test stretch, which neither fit nor selection has seen.
    pub validation_deg: f64,
    /// Within blocks of a fifteenth of the test stretch, each less its own mean: the error
    /// that is no drift.
    pub within_blocks_deg: f64,
}

impl ErrorDeg {
    /// Measures an error over the whole record.
    pub(crate) fn new(record: &SensorRecord, residual_deg: &[f64]) -> Self {
        let [fit, selection, test] = record.stretches().divide(record, residual_deg);
        Self {
            fit_deg: rms(fit),
            selection_deg: rms(selection),
            validation_deg: rms(test),
            within_blocks_deg: BlockErrors::new(test, BLOCKS).within_deg(),
        }
    }
}

/// A simpler correction that an explanation is compared with.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Baseline {
    /// Name of the correction.
    pub name: &'static str,
    /// Its error.
    #[serde(flatten)]
    pub error_deg: ErrorDeg,
}

/// An effect that was tried last on top of those added, and what came of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Candidate {
    /// Name of the effect.
    pub kind: String,
    /// Its parameters as fitted on the fit stretch, empty where it could not be tried.
    pub parameters: BTreeMap<String, f64>,
    /// Error on the selection stretch, together with the effects added before.
    pub selection_deg: Option<f64>,
    /// The same on the test stretch, which did not decide about it.
    pub validation_deg: Option<f64>,
    /// What was decided, and why.
    pub verdict: String,
}

/// The residual on the test stretch.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ResidualDescription {
    /// The sensor's axis, if known.
    pub axis: Option<char>,
    /// Frequency of the strongest oscillation.
    pub frequency_hz: Option<f64>,
    /// Its amplitude.
    pub amplitude_deg: Option<f64>,
    /// Mean of the residual.
    pub mean_deg: f64,
    /// Residual of the last tenth less that of the first tenth of the test stretch.
    pub drift_deg: f64,
    /// Probability that white noise is as correlated (Ljung and Box, 20 lags).
    pub whiteness_p_value: f64,
    /// What it looks like.
    pub explains: String,
}

/// Why the integral of a gyroscope's rate misses a measured angle.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SensorExplanation {
    /// How the record was divided.
    pub stretches_s: Stretches,
    /// Effects in the order added; empty where the model lacks nothing.
    pub effects: Vec<Effect>,
    /// Whether the error on the test stretch is above three times the noise floor.
    pub unexplained: bool,
    /// Error of the data sheet's model.
    pub error_before: ErrorDeg,
    /// Error with all effects, fitted on fit and selection stretch.
    pub error_after: ErrorDeg,
    /// What simpler corrections achieve; the data sheet is the first.
    pub baselines: Vec<Baseline>,
    /// Error on the test stretch that noise alone would leave, as measured before it.
    pub noise_floor_deg: f64,
    /// Every effect of the library that was not added.
    pub candidates: Vec<Candidate>,
    /// What is left.
    pub residual: ResidualDescription,
    /// What else to know.
    pub warnings: Vec<String>,
}
