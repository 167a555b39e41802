use mlr_filter::SettingError;
use mlr_model::LegLayout;
use serde::{Deserialize, Serialize};

use super::CrossoverUnit;

/// Parameters of the genetic algorithm.
///
/// [`GeneticSettings::paper`] is the algorithm as published, [`GeneticSettings::default`] the
/// one that proposes candidates to the default decision. What differs between them, and why,
/// stands in `docs/decision.md`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct GeneticSettings {
    /// P_s, candidates in a population; at least 2.
    pub population: usize,
    /// G_s, the most generations after the initial population.
    pub generations: usize,
    /// CR, the probability that a unit of a candidate of the worse half is replaced by that of
    /// a random candidate of the better half.
    pub crossover_rate: f64,
    /// What is replaced as a whole.
    pub crossover_unit: CrossoverUnit,
    /// MR, the probability that a leg of a new candidate is drawn anew.
    pub mutation_rate: f64,
    /// P_ij, the probability that link j of a drawn leg exists, from the body
    /// outward. The last one counts for all further links of longer legs.
    pub link_probability: Vec<f64>,
    /// Whether a child must differ from every candidate that the run has had, because evaluating
    /// one twice teaches nothing; otherwise, from those of its own population.
    pub novel: bool,
    /// Stop when the best cost has not improved for this many generations.
    /// Never, if absent.
    pub patience: Option<usize>,
    /// Populations that evolve side by side without exchange; the best of all is the result.
    pub islands: usize,
    /// Whether the healthy robot is evaluated beside the initial populations.
    pub healthy: bool,
    /// Whether a local search over single legs follows the last generation.
    pub refine: bool,
    /// Whether likely damage that no generation has met is evaluated afterwards: every damage
    /// to at most two legs, and other links of the legs that the leading candidates have damaged.
    pub complete: bool,
    /// Independent runs with consecutive seeds. The most frequent result is the run that is
    /// reported, and where the cost alone decides, the answer.
    pub repeats: usize,
}

impl Default for GeneticSettings {
    fn default() -> Self {
        Self {
            crossover_unit: CrossoverUnit::Leg,
            novel: true,
            islands: 2,
            healthy: true,
            refine: true,
            complete: true,
            repeats: 1,
            ..Self::paper()
        }
    }
}

impl GeneticSettings {
    /// The algorithm of the paper, with the values of its table of parameters and the number of
    /// runs that its results are the most frequent of.
    pub fn paper() -> Self {
        Self {
            population: 10,
            generations: 20,
            crossover_rate: 0.9,
            crossover_unit: CrossoverUnit::Link,
            mutation_rate: 0.33,
            link_probability: vec![0.9, 0.7, 0.7],
            novel: false,
            patience: None,
            islands: 1,
            healthy: false,
            refine: false,
            complete: false,
            repeats: 10,
        }
    }

    /// Checks every number. No generations are valid: then the initial populations are
    /// refined.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        SettingError::check("population", self.population, 2..=10_000, "candidates")?;
        SettingError::check("generations", self.generations, 0..=10_000, "")?;
        SettingError::check("crossover_rate", self.crossover_rate, 0.0..=1.0, "")?;
        SettingError::check("mutation_rate", self.mutation_rate, 0.0..=1.0, "")?;
        if self.link_probability.is_empty() {
            let expected = "at least one probability";
            return Err(SettingError::new("link_probability", "[]", expected));
        }
        let probabilities = &self.link_probability;
        SettingError::check_each("link_probability", probabilities, 0.0..=1.0, "")?;
        if let Some(patience) = self.patience {
            SettingError::check("patience", patience, 1..=10_000, "generations")?;
        }
        SettingError::check("islands", self.islands, 1..=100, "")?;
        SettingError::check("repeats", self.repeats, 1..=10_000, "runs")
    }

    /// P_ij for link `link` (from 0).
    pub(super) fn link_probability(&self, link: usize) -> f64 {
        self.link_probability
            .get(link)
            .or(self.link_probability.last())
            .copied()
            .unwrap_or(1.0)
    }

    /// About how many candidates a run evaluates: healthy, the initial
    /// populations, half a population per generation, and four rounds of
    /// refinement.
    pub(super) fn evaluations(&self, layout: &LegLayout) -> usize {
        let children = self.population - self.population / 2;
        let evolution = self.islands * (self.population + self.generations * children);
        let refinement = if self.refine {
            4 * layout.total_links()
        } else {
            0
        };
        let feasible = layout
            .count()
            .and_then(|count| usize::try_from(count).ok())
            .unwrap_or(usize::MAX);
        (usize::from(self.healthy) + evolution + refinement).min(feasible)
    }
}
