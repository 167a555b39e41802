use std::collections::BTreeSet;

use mlr_model::{LegLayout, Morphology};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::{GeneticSettings, crossover, mutation};
use crate::Evaluations;

/// Draws of one candidate before the search accepts that there is nothing new
/// within its reach.
const ATTEMPTS: usize = 1000;

/// The candidates of one island: all different, all feasible.
#[derive(Debug, Clone)]
pub struct Population {
    candidates: Vec<Morphology>,
    generator: ChaCha8Rng,
}

impl Population {
    /// P_s random candidates that are not in `seen`, fewer where there are not
    /// so many. Adds them to `seen`.
    ///
    /// Islands with the same seed draw from different streams of one generator.
    pub fn random(
        layout: &LegLayout,
        settings: &GeneticSettings,
        seed: u64,
        island: u64,
        seen: &mut BTreeSet<Morphology>,
    ) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(island);
        let mut candidates = Vec::with_capacity(settings.population);
        for _ in 0..settings.population {
            let drawn = (0..ATTEMPTS)
                .map(|_| mutation::random_candidate(layout, settings, &mut generator))
                .find(|candidate| !seen.contains(candidate));
            if let Some(candidate) = drawn {
                seen.insert(candidate.clone());
                candidates.push(candidate);
            }
        }
        Self {
            candidates,
            generator,
        }
    }

    /// The candidates.
    pub fn candidates(&self) -> &[Morphology] {
        &self.candidates
    }

    /// Replaces the worse half by new candidates: crossover, then mutation, repeated until
    /// the result is new: in no population that `seen` knows of, or not in this one, as the
    /// settings say. A candidate that finds nothing new stays as it is. Returns how many are
    /// new.
    pub fn breed(
        &mut self,
        settings: &GeneticSettings,
        evaluations: &Evaluations<'_>,
        seen: &mut BTreeSet<Morphology>,
    ) -> usize {
        self.candidates.sort_by(|a, b| evaluations.order(a, b));
        let half = self.candidates.len() / 2;
        let mut children = 0;
        for index in half..self.candidates.len() {
            let (candidate, better) = (&self.candidates[index], &self.candidates[..half]);
            let is_known = |child: &Morphology| match settings.novel {
                true => seen.contains(child),
                false => self.candidates.contains(child),
            };
            let child = (0..ATTEMPTS)
                .map(|_| {
                    let crossed =
                        crossover::cross(candidate, better, settings, &mut self.generator);
                    mutation::mutate(&crossed, settings, &mut self.generator)
                })
                .find(|child| !is_known(child));
            if let Some(child) = child {
                seen.insert(child.clone());
                self.candidates[index] = child;
                children += 1;
            }
        }
        children
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::evaluation::tests::Distance;

    fn all_different(population: &Population) -> bool {
        let unique: BTreeSet<_> = population.candidates().iter().collect();
        unique.len() == population.candidates().len()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn every_generation_is_unique_and_feasible(
            links in prop::collection::vec(1_usize..4, 3..7),
            seed in any::<u64>(),
        ) {
            let layout = LegLayout::new(links).unwrap();
            let settings = GeneticSettings::default();
            let objective = Distance::to(Morphology::healthy(&layout).without_leg(1));
            let mut evaluations = Evaluations::new(&objective, &());
            let mut seen = BTreeSet::new();
            let mut population = Population::random(&layout, &settings, seed, 0, &mut seen);
            let size = population.candidates().len();
            for _ in 0..settings.generations {
                prop_assert!(all_different(&population));
                prop_assert_eq!(population.candidates().len(), size);
                for candidate in population.candidates() {
                    let again = Morphology::from_existence(&layout, &candidate.existence()).unwrap();
                    prop_assert_eq!(&again, candidate, "link logic changes nothing");
                }
                evaluations.evaluate(population.candidates());
                population.breed(&settings, &evaluations, &mut seen);
            }
        }

        #[test]
        fn the_better_half_survives(seed in any::<u64>()) {
            let layout = LegLayout::new([3; 6]).unwrap();
            let settings = GeneticSettings::default();
            let objective = Distance::to(Morphology::healthy(&layout));
            let mut evaluations = Evaluations::new(&objective, &());
            let mut seen = BTreeSet::new();
            let mut population = Population::random(&layout, &settings, seed, 0, &mut seen);
            evaluations.evaluate(population.candidates());
            let mut ranked = population.candidates().to_vec();
            ranked.sort_by(|a, b| evaluations.order(a, b));
            population.breed(&settings, &evaluations, &mut seen);
            prop_assert_eq!(&population.candidates()[..5], &ranked[..5]);
        }
    }

    #[test]
    fn islands_of_one_seed_differ() {
        let layout = LegLayout::new([3; 6]).unwrap();
        let settings = GeneticSettings::default();
        let draw = |island| {
            Population::random(&layout, &settings, 1, island, &mut BTreeSet::new())
                .candidates()
                .to_vec()
        };
        assert_eq!(draw(0), draw(0));
        assert_ne!(draw(0), draw(1));
    }
}
