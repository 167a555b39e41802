use mlr_model::{LegLayout, Morphology};
use rand::{Rng, RngExt};

use super::GeneticSettings;

/// Draws each leg anew with the probability MR (Eq. (ga_mutation)).
pub(super) fn mutate(
    candidate: &Morphology,
    settings: &GeneticSettings,
    generator: &mut impl Rng,
) -> Morphology {
    redraw_legs(candidate, settings, settings.mutation_rate, generator)
}

/// A candidate of the initial population: all of its legs are drawn.
pub(super) fn random_candidate(
    layout: &LegLayout,
    settings: &GeneticSettings,
    generator: &mut impl Rng,
) -> Morphology {
    redraw_legs(&Morphology::healthy(layout), settings, 1.0, generator)
}

/// With the probability `rate` per leg, gives every link j of the leg an
/// existence number that is 1 with the probability P_ij, then applies link
/// logic.
fn redraw_legs(
    candidate: &Morphology,
    settings: &GeneticSettings,
    rate: f64,
    generator: &mut impl Rng,
) -> Morphology {
    let mut existence = Vec::new();
    for leg in 0..candidate.legs() {
        let redraw = generator.random_bool(rate);
        for link in 0..candidate.links(leg) {
            existence.push(if redraw {
                generator.random_bool(settings.link_probability(link))
            } else {
                candidate.exists(leg, link)
            });
        }
    }
    Morphology::from_existence(&candidate.layout(), &existence)
        .expect("one existence number was made for every link of the layout")
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// Shares of legs with 0, 1, 2, 3 links among many mutants of `parent`.
    fn shares(parent: &Morphology, settings: &GeneticSettings) -> [f64; 4] {
        let mut generator = ChaCha8Rng::seed_from_u64(7);
        let mut counts = [0.0; 4];
        for _ in 0..5000 {
            let mutant = mutate(parent, settings, &mut generator);
            for leg in 0..mutant.legs() {
                counts[mutant.remaining(leg)] += 1.0;
            }
        }
        counts.map(|count| count / (5000.0 * parent.legs() as f64))
    }

    #[test]
    fn legs_follow_the_link_probabilities() {
        let layout = LegLayout::new([3; 6]).unwrap();
        let parent = Morphology::parse_legs_lost("1,2,3,4,5,6", &layout).unwrap();
        let drawn = 0.33;
        let expected = [
            1.0 - drawn + drawn * 0.1,
            drawn * 0.9 * 0.3,
            drawn * 0.9 * 0.7 * 0.3,
            drawn * 0.9 * 0.7 * 0.7,
        ];
        let shares = shares(&parent, &GeneticSettings::default());
        for (share, expected) in shares.iter().zip(expected) {
            assert!((share - expected).abs() < 0.01, "{shares:?}");
        }
    }

    #[test]
    fn without_a_mutation_rate_nothing_changes() {
        let layout = LegLayout::new([3, 2]).unwrap();
        let parent = Morphology::parse("110 10", &layout).unwrap();
        let settings = GeneticSettings {
            mutation_rate: 0.0,
            ..Default::default()
        };
        let mut generator = ChaCha8Rng::seed_from_u64(1);
        assert_eq!(mutate(&parent, &settings, &mut generator), parent);
    }
}
