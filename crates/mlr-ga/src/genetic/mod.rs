//! The genetic algorithm of the paper.
//!
//! A binary search over morphology vectors with population size P_s and G_s
//! generations:
//!
//! 1. **Initialisation**: P_s unique random candidates under link logic.
//! 2. **Evaluation**: each candidate's cost, in parallel, remembered.
//! 3. **Crossover**: ranked by cost, the better half stays; in each candidate of the worse
//!    half, every link is replaced with the probability CR by that of a random candidate of the
//!    better half (Eq. (ga_crossover)), then link logic.
//! 4. **Mutation**: each leg of these is drawn anew with the probability MR,
//!    link j existing with the probability P_ij (Eq. (ga_mutation)), then link logic.
//! 5. **Selection**: the better half and the new candidates are the next
//!    generation.
//! 6. **Termination** after G_s generations.
//!
//! That is [`GeneticSettings::paper`]: 10 + 20 · 5 = 110 candidates. Where the paper leaves a
//! choice: a random candidate is drawn link by link with the probabilities P_ij, the partner of a
//! crossover is drawn for every link, and a child must differ from every candidate of its
//! population.
//!
//! [`GeneticSettings::default`] only proposes candidates to a decision that weighs them. It
//! crosses whole legs, never evaluates a candidate again, evolves several populations side by side, and then tries every change of a single leg,
//! from the best candidate and from the healthy robot. What each of these is worth stands in
//! `docs/decision.md`.
//!
//! Source: Farghdani, Patel, Chhabra, *Robust Embodied Self-Identification of
//! Morphology in Damaged Multi-Legged Robots*, section "Genetic Algorithm for
//! MLRs".

mod crossover;
mod mutation;
mod population;
mod refinement;
mod settings;

pub use crossover::CrossoverUnit;
pub use population::Population;
pub use settings::GeneticSettings;

use mlr_model::{LegLayout, Morphology};

use crate::Evaluations;

/// The course of one run.
#[derive(Debug, Clone, PartialEq)]
pub struct GeneticRun {
    /// The best morphology found.
    pub best: Morphology,
    /// Its cost.
    pub cost_deg: f64,
    /// The best cost so far after the initial population, after each
    /// generation, and, if it ran, after the refinement.
    pub cost_per_generation: Vec<f64>,
    /// Candidates of all populations, each counted when it entered one: P_s + G_s · P_s / 2,
    /// unless the robot has fewer morphologies.
    pub candidates: usize,
}

/// Runs the genetic algorithm once.
///
/// What `evaluations` already knows costs nothing, but plays no part in the
/// search: the run is the same whether or not another one came before.
pub fn search(
    layout: &LegLayout,
    settings: &GeneticSettings,
    seed: u64,
    evaluations: &mut Evaluations<'_>,
) -> GeneticRun {
    evaluations
        .progress()
        .expect(evaluations.len() + settings.evaluations(layout));
    let mut run = Run::start(layout, settings, seed, evaluations);
    let mut stalled = 0;
    for _ in 0..settings.generations {
        let before = run.best_cost(evaluations);
        run.next_generation(settings, evaluations);
        stalled = if run.best_cost(evaluations) < before {
            0
        } else {
            stalled + 1
        };
        if settings
            .patience
            .is_some_and(|patience| stalled >= patience)
        {
            break;
        }
    }
    if settings.refine {
        run.refine(layout, evaluations);
    }
    run.finish(evaluations)
}

/// The state of one run: its islands and what they have seen.
struct Run {
    islands: Vec<Population>,
    seen: std::collections::BTreeSet<Morphology>,
    best: Morphology,
    cost_per_generation: Vec<f64>,
    candidates: usize,
}

impl Run {
    fn start(
        layout: &LegLayout,
        settings: &GeneticSettings,
        seed: u64,
        evaluations: &mut Evaluations<'_>,
    ) -> Self {
        let mut run = Self {
            islands: Vec::new(),
            seen: std::collections::BTreeSet::new(),
            best: Morphology::healthy(layout),
            cost_per_generation: Vec::new(),
            candidates: 0,
        };
        if settings.healthy {
            run.seen.insert(run.best.clone());
            evaluations.evaluate(std::slice::from_ref(&run.best));
        }
        for island in 0..settings.islands {
            let population =
                Population::random(layout, settings, seed, island as u64, &mut run.seen);
            run.candidates += population.candidates().len();
            run.islands.push(population);
        }
        run.evaluate(evaluations);
        run
    }

    fn next_generation(&mut self, settings: &GeneticSettings, evaluations: &mut Evaluations<'_>) {
        for island in &mut self.islands {
            self.candidates += island.breed(settings, evaluations, &mut self.seen);
        }
        self.evaluate(evaluations);
    }

    fn evaluate(&mut self, evaluations: &mut Evaluations<'_>) {
        let candidates: Vec<Morphology> = self
            .islands
            .iter()
            .flat_map(Population::candidates)
            .cloned()
            .collect();
        evaluations.evaluate(&candidates);
        self.improve(&candidates, evaluations);
    }

    /// Local search from the best candidate of all islands, and from the healthy
    /// robot: the loss of a single leg is the likeliest damage, and a narrow
    /// valley that a population easily steps over.
    fn refine(&mut self, layout: &LegLayout, evaluations: &mut Evaluations<'_>) {
        let found = [&self.best, &Morphology::healthy(layout)]
            .map(|start| refinement::climb(start, evaluations));
        self.improve(&found, evaluations);
    }

    fn improve(&mut self, candidates: &[Morphology], evaluations: &Evaluations<'_>) {
        if let Some(best) = candidates
            .iter()
            .min_by(|a, b| evaluations.order(a, b))
            .filter(|best| evaluations.order(best, &self.best).is_lt())
        {
            self.best = best.clone();
        }
        self.cost_per_generation.push(self.best_cost(evaluations));
    }

    fn best_cost(&self, evaluations: &Evaluations<'_>) -> f64 {
        evaluations
            .get(&self.best)
            .map_or(f64::INFINITY, |evaluation| evaluation.cost_deg)
    }

    fn finish(self, evaluations: &Evaluations<'_>) -> GeneticRun {
        GeneticRun {
            cost_deg: self.best_cost(evaluations),
            best: self.best,
            cost_per_generation: self.cost_per_generation,
            candidates: self.candidates,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::Ordering;

    use proptest::prelude::*;

    use super::*;
    use crate::evaluation::tests::Distance;

    fn run(target: &Morphology, settings: &GeneticSettings, seed: u64) -> (GeneticRun, usize) {
        let objective = Distance::to(target.clone());
        let mut evaluations = Evaluations::new(&objective, &());
        let run = search(&target.layout(), settings, seed, &mut evaluations);
        (run, objective.calls.load(Ordering::Relaxed))
    }

    fn hexapod(text: &str) -> Morphology {
        Morphology::parse(text, &LegLayout::new([3; 6]).unwrap()).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn repeatable_and_never_worse_from_one_generation_to_the_next(
            seed in any::<u64>(),
            bits in prop::collection::vec(any::<bool>(), 18),
        ) {
            let layout = LegLayout::new([3; 6]).unwrap();
            let target = Morphology::from_existence(&layout, &bits).unwrap();
            let settings = GeneticSettings::default();
            let (first, evaluations) = run(&target, &settings, seed);
            prop_assert_eq!(&first, &run(&target, &settings, seed).0);
            prop_assert!(first.cost_per_generation.is_sorted_by(|a, b| b <= a));
            prop_assert_eq!(first.best, target, "one smooth hill");
            prop_assert!(evaluations <= 1 + 2 * (10 + 20 * 5) + 2 * 8 * 18);
        }

        #[test]
        fn small_robots_are_searched_to_the_end(
            links in prop::collection::vec(1_usize..3, 1..3),
            seed in any::<u64>(),
        ) {
            let layout = LegLayout::new(links).unwrap();
            let target = layout.enumerate().last().unwrap();
            let (found, evaluations) = run(&target, &GeneticSettings::default(), seed);
            prop_assert_eq!(found.best, target);
            prop_assert!(evaluations as u128 <= layout.count().unwrap());
        }
    }

    #[test]
    fn an_earlier_run_changes_nothing_but_the_time() {
        let target = hexapod("111 100 111 110 111 000");
        let settings = GeneticSettings::default();
        let (alone, _) = run(&target, &settings, 2);
        let objective = Distance::to(target.clone());
        let mut evaluations = Evaluations::new(&objective, &());
        search(&target.layout(), &settings, 1, &mut evaluations);
        let second = search(&target.layout(), &settings, 2, &mut evaluations);
        assert_eq!(alone, second);
    }

    #[test]
    fn stops_when_nothing_improves_for_long_enough() {
        let healthy = hexapod("111 111 111 111 111 111");
        let settings = GeneticSettings {
            patience: Some(3),
            refine: false,
            ..Default::default()
        };
        let (found, _) = run(&healthy, &settings, 1);
        assert_eq!(
            found.cost_per_generation, [0.0; 4],
            "healthy is known from the start"
        );
        let impatient = GeneticSettings {
            patience: None,
            ..settings
        };
        assert_eq!(run(&healthy, &impatient, 1).0.cost_per_generation.len(), 21);
    }

    #[test]
    fn the_papers_loop_has_110_candidates() {
        let target = hexapod("000 111 111 000 111 111");
        for seed in 1..=10 {
            let (found, evaluated) = run(&target, &GeneticSettings::paper(), seed);
            assert_eq!(found.candidates, 10 + 20 * 5);
            assert_eq!(found.cost_per_generation.len(), 1 + 20);
            // Those that a population had before are known.
            assert!(evaluated <= found.candidates, "{evaluated}");
        }
    }

    /// Of five seeds, how many find every one of these: three and four damaged legs with some of
    /// their links, which nothing but evolution tries.
    fn hits(settings: &GeneticSettings) -> usize {
        let targets = [
            "110 111 000 100 111 111",
            "100 110 111 111 000 110",
            "111 100 110 100 111 000",
        ];
        targets
            .iter()
            .flat_map(|target| (1..=5).map(move |seed| (hexapod(target), seed)))
            .filter(|(target, seed)| run(target, settings, *seed).0.best == *target)
            .count()
    }

    #[test]
    fn crossover_and_mutation_together_find_what_neither_finds_alone() {
        let evolution = GeneticSettings {
            islands: 1,
            population: 10,
            generations: 40,
            refine: false,
            ..Default::default()
        };
        let with = hits(&evolution);
        let without_crossover = hits(&GeneticSettings {
            crossover_rate: 0.0,
            ..evolution.clone()
        });
        let without_mutation = hits(&GeneticSettings {
            mutation_rate: 0.0,
            ..evolution.clone()
        });
        // As many candidates without any evolution.
        let random = hits(&GeneticSettings {
            population: 10 + 40 * 5,
            generations: 0,
            ..evolution
        });
        let found = [with, without_crossover, without_mutation, random];
        assert!(with >= 12, "{found:?}");
        assert!(without_crossover <= with / 2, "{found:?}");
        assert!(without_mutation <= with / 2, "{found:?}");
        assert!(random <= with / 2, "{found:?}");
    }
}
