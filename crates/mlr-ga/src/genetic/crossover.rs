use mlr_model::Morphology;
use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use super::GeneticSettings;

/// What a new candidate takes over as a whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum CrossoverUnit {
    /// One existence number, as in Eq. (ga_crossover). Link logic then removes what hangs on
    /// nothing, so that mixed legs lose links that neither parent has lost.
    Link,
    /// One leg with all its links: it stays as it was in one of the parents.
    #[default]
    Leg,
}

/// Eq. (ga_crossover): with the probability CR, each unit of the candidate is replaced by that
/// of a candidate of the `better` half, drawn anew for each unit. Link logic comes after it.
pub(super) fn cross(
    candidate: &Morphology,
    better: &[Morphology],
    settings: &GeneticSettings,
    generator: &mut impl Rng,
) -> Morphology {
    let mut parent = || match better.len() {
        partners if partners > 0 && generator.random_bool(settings.crossover_rate) => {
            &better[generator.random_range(0..partners)]
        }
        _ => candidate,
    };
    let mut existence = Vec::with_capacity(candidate.layout().total_links());
    for leg in 0..candidate.legs() {
        let links = 0..candidate.links(leg);
        match settings.crossover_unit {
            CrossoverUnit::Link => existence.extend(links.map(|link| parent().exists(leg, link))),
            CrossoverUnit::Leg => {
                let parent = parent();
                existence.extend(links.map(|link| parent.exists(leg, link)));
            }
        }
    }
    Morphology::from_existence(&candidate.layout(), &existence)
        .expect("one existence number was made for every link of the layout")
}

#[cfg(test)]
mod tests {
    use mlr_model::LegLayout;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn hexapod(text: &str) -> Morphology {
        Morphology::parse(text, &LegLayout::new([3; 6]).unwrap()).unwrap()
    }

    fn children(
        candidate: &Morphology,
        better: &[Morphology],
        settings: &GeneticSettings,
    ) -> Vec<Morphology> {
        let mut generator = ChaCha8Rng::seed_from_u64(1);
        (0..10_000)
            .map(|_| cross(candidate, better, settings, &mut generator))
            .collect()
    }

    fn share(children: &[Morphology], what: impl Fn(&Morphology) -> bool) -> f64 {
        children.iter().filter(|child| what(child)).count() as f64 / children.len() as f64
    }

    #[test]
    fn every_unit_crosses_as_often_as_the_rate_says_whatever_the_others_do() {
        // With one better candidate, a unit shows which parent it comes from.
        let candidate = hexapod("111 111 111 111 111 111");
        let better = [hexapod("000 000 000 000 000 000")];
        let leg_by_leg = children(&candidate, &better, &GeneticSettings::default());
        for leg in 0..6 {
            let lost = share(&leg_by_leg, |child| child.remaining(leg) == 0);
            assert!((lost - 0.9).abs() < 0.02, "leg {leg}: {lost}");
        }
        let both_stay = share(&leg_by_leg, |child| {
            child.remaining(0) == 3 && child.remaining(1) == 3
        });
        assert!((both_stay - 0.01).abs() < 0.005, "{both_stay}");
        let link_by_link = children(&candidate, &better, &GeneticSettings::paper());
        // Link logic: a leg is whole where all of its three links stayed.
        let whole = share(&link_by_link, |child| child.remaining(0) == 3);
        assert!((whole - 0.1_f64.powi(3)).abs() < 0.001, "{whole}");
        let coxa = share(&link_by_link, |child| child.remaining(0) > 0);
        assert!((coxa - 0.1).abs() < 0.02, "{coxa}");
    }

    #[test]
    fn brings_together_what_no_parent_has_alone() {
        let candidate = hexapod("111 111 111 111 111 111");
        let better = [
            hexapod("000 111 111 111 111 111"),
            hexapod("111 111 111 110 111 111"),
        ];
        let both = hexapod("000 111 111 110 111 111");
        for settings in [GeneticSettings::default(), GeneticSettings::paper()] {
            let mixed = children(&candidate, &better, &settings);
            assert!(share(&mixed, |child| *child == both) > 0.05);
        }
        // The control: without crossover nothing is brought together.
        let without = GeneticSettings {
            crossover_rate: 0.0,
            ..Default::default()
        };
        let unmixed = children(&candidate, &better, &without);
        assert_eq!(share(&unmixed, |child| *child == candidate), 1.0);
    }

    #[test]
    fn legs_stay_as_one_of_the_parents_has_them() {
        let candidate = hexapod("110 110 110 110 110 110");
        let better = [
            hexapod("000 111 000 111 000 111"),
            hexapod("111 000 111 000 111 000"),
        ];
        let has_short_leg = |child: &Morphology| (0..6).any(|leg| child.remaining(leg) == 1);
        let by_legs = children(&candidate, &better, &GeneticSettings::default());
        assert_eq!(share(&by_legs, has_short_leg), 0.0);
        // The control: link by link, legs come about that no parent has.
        let by_links = children(&candidate, &better, &GeneticSettings::paper());
        assert!(share(&by_links, has_short_leg) > 0.5);
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
