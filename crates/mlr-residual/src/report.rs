//! What an explanation says.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// An effect that was added to the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Effect {
    /// Name of the effect.
    pub kind: String,
    /// Value of each parameter; the name ends in the unit.
    pub parameters: BTreeMap<String, f64>,
    /// 95 % interval of each parameter that the record determines.
    #[serde(default)]
    pub interval_95: BTreeMap<String, [f64; 2]>,
    /// Error with this effect and all before it, when it was added.
    #[serde(default)]
    pub error_deg: Option<ErrorDeg>,
    /// The trace that it leaves.
    #[serde(default)]
    pub explains: String,
    /// The chance of the gain, had the effect none; see
    /// [`explain_sensor()`](crate::explain_sensor()).
    #[serde(default)]
    pub chance: Option<f64>,
    /// Other candidates that did as well within noise when it was added.
    #[serde(default)]
    pub rivals: Vec<String>,
}

/// Root mean square errors in degrees.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ErrorDeg {
    /// On the half that the parameters were fitted on.
    pub fit_deg: f64,
    /// On the half that they never saw.
    pub validation_deg: f64,
    /// Within blocks of a fifteenth of the unseen half, each less its own mean: the
    /// error that is no drift.
    #[serde(default)]
    pub within_blocks_deg: f64,
}

/// An effect that was tried last on top of those added, and what came of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Candidate {
    /// Name of the effect.
    pub kind: String,
    /// Its parameters as fitted, empty where it could not be tried.
    pub parameters: BTreeMap<String, f64>,
    /// Error on the unseen half together with the effects added before.
    pub validation_deg: Option<f64>,
    /// What was decided, and why.
    pub verdict: String,
}

/// What remains on the unseen half.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ResidualDescription {
    /// The sensor's axis, if known.
    pub axis: Option<char>,
    /// Frequency of the strongest oscillation.
    pub frequency_hz: Option<f64>,
    /// Its amplitude.
    pub amplitude_deg: Option<f64>,
    /// Mean of the residual.
    pub mean_deg: f64,
    /// Residual of the last tenth less that of the first tenth of the unseen half.
    pub drift_deg: f64,
    /// Probability that white noise is as correlated (Ljung and Box, 20 lags).
    pub whiteness_p_value: f64,
    /// What it looks like.
    pub explains: String,
}

/// Why the integral of a gyroscope's rate misses a measured angle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SensorExplanation {
    /// Effects in the order added; empty where the model lacks nothing.
    pub effects: Vec<Effect>,
    /// Whether what remains is more than noise and no effect of the library removes it.
    pub unexplained: bool,
    /// Error of the data sheet's model.
    pub error_before: ErrorDeg,
    /// Error with all effects.
    pub error_after: ErrorDeg,
    /// Error on the unseen half that noise alone would leave, as measured on the other.
    pub noise_floor_deg: f64,
    /// Every effect of the library that was not added.
    pub candidates: Vec<Candidate>,
    /// What remains.
    pub residual: ResidualDescription,
    /// Length of each half.
    pub half_s: f64,
    /// What else to know.
    pub warnings: Vec<String>,
}
