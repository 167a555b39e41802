use mlr_filter::Conditioned;
use mlr_model::LostLinks;
use serde::Serialize;

/// The answer. Serialises to the fields of `mlr.identification/1`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Identification {
    /// The best morphology's existence numbers, leg by leg.
    pub morphology: Vec<Vec<u8>>,
    /// Numbers (from 1) of the legs that miss a link.
    pub damaged_legs: Vec<usize>,
    /// The damage in words.
    pub description: String,
    /// What the lost links were taken to be.
    pub lost_links: LostLinks,
    /// F of the best morphology.
    pub cost_rad: f64,
    /// F per sample and axis.
    pub mean_error_deg: f64,
    /// The next best morphologies.
    pub alternatives: Vec<Alternative>,
    /// Log time at which the walk started, if the recording shows it.
    pub motion_start_s: Option<f64>,
    /// Log time at which the compared stretch begins.
    pub window_start_s: f64,
    /// Length of the compared stretch.
    pub window_s: f64,
    /// Morphologies simulated.
    pub evaluations: usize,
    /// Simulations that diverged and count as infinitely costly.
    pub diverged: usize,
    /// Best cost so far, generation by generation; of the run that gave the
    /// answer. Empty for the exact search.
    pub cost_per_generation: Vec<f64>,
    /// The results of repeated runs, most frequent first. Empty for a single
    /// run.
    pub frequencies: Vec<Frequency>,
    /// What a person should know about the recording.
    pub warnings: Vec<String>,
    /// What was compared.
    #[serde(skip)]
    pub signals: ComparedSignals,
}

/// Measured and simulated orientation after the filter, from the start of the
/// walk on.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparedSignals {
    /// Rate of the common time vector.
    pub rate_hz: f64,
    /// The recording.
    pub measured: Conditioned,
    /// The walk of the best morphology.
    pub simulated: Conditioned,
}

/// A morphology that explains the recording less well.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Alternative {
    /// Existence numbers, leg by leg.
    pub morphology: Vec<Vec<u8>>,
    /// Its F.
    pub cost_rad: f64,
}

/// How often repeated runs of the genetic algorithm gave a morphology.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Frequency {
    /// Existence numbers, leg by leg.
    pub morphology: Vec<Vec<u8>>,
    /// Its F.
    pub cost_rad: f64,
    /// Runs that ended with it.
    pub count: usize,
}
