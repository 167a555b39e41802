use mlr_model::Morphology;
use rand::{Rng, RngExt};

use super::GeneticSettings;

/// Eq. (ga_crossover): with the probability CR the candidate takes over every
/// link of a random one of the better half, otherwise it stays as it is.
pub(super) fn cross(
    candidate: &Morphology,
    better: &[Morphology],
    settings: &GeneticSettings,
    generator: &mut impl Rng,
) -> Morphology {
    let crosses = generator.random_bool(settings.crossover_rate);
    match better.len() {
        0 => candidate.clone(),
        _ if !crosses => candidate.clone(),
        partners => better[generator.random_range(0..partners)].clone(),
    }
}

#[cfg(test)]
mod tests {
    use mlr_model::LegLayout;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn happens_as_often_as_the_crossover_rate_says() {
        let layout = LegLayout::new([3; 6]).unwrap();
        let healthy = Morphology::healthy(&layout);
        let better = [
            healthy.clone().without_leg(0),
            healthy.clone().without_leg(1),
        ];
        let mut generator = ChaCha8Rng::seed_from_u64(1);
        let settings = GeneticSettings::default();
        let children: Vec<_> = (0..10_000)
            .map(|_| cross(&healthy, &better, &settings, &mut generator))
            .collect();
        let share = |m: &Morphology| {
            children.iter().filter(|child| *child == m).count() as f64 / children.len() as f64
        };
        assert!((share(&healthy) - 0.1).abs() < 0.02);
        assert!((share(&better[0]) - 0.45).abs() < 0.02);
        assert!((share(&better[1]) - 0.45).abs() < 0.02);
    }

    #[test]
    fn without_a_better_half_nothing_changes() {
        let layout = LegLayout::new([1]).unwrap();
        let candidate = Morphology::healthy(&layout);
        let mut generator = ChaCha8Rng::seed_from_u64(1);
        let child = cross(&candidate, &[], &GeneticSettings::default(), &mut generator);
        assert_eq!(child, candidate);
    }
}
