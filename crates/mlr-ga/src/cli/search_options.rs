//! How the morphologies are searched.

use clap::{Args, ValueEnum};
use mlr_ga::{IdentifyOverrides, LARGEST_SEED, Search};

/// The options of every command that identifies a robot.
#[derive(Debug, Args)]
pub(super) struct SearchOptions {
    /// How to search the morphologies [default: atlas where there is one, else ga].
    #[arg(long, value_enum)]
    search: Option<SearchName>,
    /// Makes every run repeatable.
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true,
          value_parser = clap::value_parser!(u64).range(..=LARGEST_SEED))]
    seed: u64,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum SearchName {
    /// The genetic algorithm. By --method mlr, likely damage is evaluated in any case.
    Ga,
    /// Every feasible morphology.
    Exact,
    /// Every feasible morphology, from --atlas.
    Atlas,
}

impl SearchOptions {
    /// What the options put in place of settings.
    pub(super) fn overrides(&self) -> IdentifyOverrides {
        IdentifyOverrides {
            search: self.search.map(Search::from),
            seed: Some(self.seed),
            ..IdentifyOverrides::default()
        }
    }
}

impl From<SearchName> for Search {
    fn from(name: SearchName) -> Self {
        match name {
            SearchName::Ga => Self::Ga,
            SearchName::Exact => Self::Exact,
            SearchName::Atlas => Self::Atlas,
        }
    }
}
