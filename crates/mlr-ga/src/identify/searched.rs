use std::collections::BTreeMap;

use mlr_model::{LegLayout, Morphology};

use super::{Course, Frequency, Search};
use crate::{
    Evaluations, exact,
    genetic::{self, GeneticRun, GeneticSettings},
};

/// The runs of the genetic algorithm; none for the exact search, whose result is what has been
/// evaluated.
#[derive(Debug, Clone, Default)]
pub(super) struct Searched {
    runs: Vec<GeneticRun>,
    /// The different results and how many runs ended with each, most frequent first; among
    /// equally frequent ones the better.
    results: Vec<(Morphology, usize)>,
}

impl Searched {
    /// Searches the morphologies of `layout`. An exact search may give up candidates that cost
    /// more than `margin` times the best.
    pub(super) fn new(
        layout: &LegLayout,
        search: Search,
        (genetic, seed): (&GeneticSettings, u64),
        margin: f64,
        evaluations: &mut Evaluations<'_>,
    ) -> Self {
        if search != Search::Ga {
            exact::search(layout, margin, evaluations);
            return Self::default();
        }
        let seeds = (0..genetic.repeats as u64).map(|repeat| seed.wrapping_add(repeat));
        let runs: Vec<GeneticRun> = seeds
            .map(|seed| genetic::search(layout, genetic, seed, evaluations))
            .collect();
        let mut counts: BTreeMap<&Morphology, usize> = BTreeMap::new();
        for run in &runs {
            *counts.entry(&run.best).or_default() += 1;
        }
        let mut results: Vec<_> = counts
            .into_iter()
            .map(|(result, count)| (result.clone(), count))
            .collect();
        results.sort_by(|(a, count_a), (b, count_b)| {
            count_b.cmp(count_a).then_with(|| evaluations.order(a, b))
        });
        Self { runs, results }
    }

    /// The results and how many runs ended with each, most frequent first.
    pub(super) fn results(&self) -> &[(Morphology, usize)] {
        &self.results
    }

    /// Candidates that the populations of all runs had.
    pub(super) fn candidates(&self) -> usize {
        self.runs.iter().map(|run| run.candidates).sum()
    }

    /// The best cost, generation by generation, of the first run that ended with the most
    /// frequent result.
    pub(super) fn cost_per_generation(&self) -> Vec<f64> {
        let most_frequent = self.results.first().map(|(result, _)| result);
        let run = self
            .runs
            .iter()
            .find(|run| Some(&run.best) == most_frequent);
        run.map_or_else(Vec::new, |run| run.cost_per_generation.clone())
    }

    /// The results of repeated runs; empty for a single one.
    pub(super) fn frequencies(&self) -> Vec<Frequency> {
        if self.runs.len() < 2 {
            return Vec::new();
        }
        let cost_of = |result: &Morphology| {
            let run = self.runs.iter().find(|run| run.best == *result);
            run.map_or(f64::INFINITY, |run| run.cost_deg)
        };
        self.results
            .iter()
            .map(|(result, count)| Frequency {
                morphology: result.clone(),
                cost_deg: cost_of(result),
                count: *count,
            })
            .collect()
    }

    /// The course of repeated runs; empty for a single one.
    pub(super) fn courses(&self) -> Vec<Course> {
        if self.runs.len() < 2 {
            return Vec::new();
        }
        self.runs
            .iter()
            .map(|run| Course {
                morphology: run.best.clone(),
                cost_per_generation: run.cost_per_generation.clone(),
            })
            .collect()
    }
}
