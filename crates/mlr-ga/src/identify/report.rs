use std::time::Duration;

use serde::Serialize;

use super::{Identification, Search};

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
    /// How the morphologies were searched.
    pub search: SearchMethod,
    /// Seed of the search.
    pub seed: u64,
    /// The answer.
    #[serde(flatten)]
    pub identification: Identification,
    /// Time that it took.
    pub elapsed_s: f64,
}

/// A [`Search`] without its parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SearchMethod {
    /// The genetic algorithm.
    Ga,
    /// Every feasible morphology.
    Exact,
    /// Every feasible morphology, simulated beforehand.
    Atlas,
}

impl From<Search> for SearchMethod {
    fn from(search: Search) -> Self {
        match search {
            Search::Genetic { .. } => Self::Ga,
            Search::Exact => Self::Exact,
            Search::Atlas => Self::Atlas,
        }
    }
}

impl IdentificationReport {
    /// The report of an identification.
    pub fn new(
        log: String,
        search: Search,
        seed: u64,
        identification: Identification,
        elapsed: Duration,
    ) -> Self {
        Self {
            schema: SCHEMA,
            log,
            search: search.into(),
            seed,
            identification,
            elapsed_s: elapsed.as_secs_f64(),
        }
    }
}
