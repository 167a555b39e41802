use mlr_model::Morphology;

use super::DamagePrior;

/// Probabilities of morphologies that exclude each other, most probable first.
#[derive(Debug, Clone, PartialEq)]
pub struct Posterior(mlr_residual::Posterior<Morphology>);

impl Posterior {
    /// Normalises logarithms of likelihood times prior. A morphology that is not
    /// among them is held to be impossible. Of equals, the lesser damage comes first.
    pub fn new(ln_weights: impl IntoIterator<Item = (Morphology, f64)>) -> Self {
        let mut ln_weights: Vec<(Morphology, f64)> = ln_weights.into_iter().collect();
        ln_weights.sort_by(|(a, _), (b, _)| b.cmp(a));
        Self(mlr_residual::Posterior::new(ln_weights))
    }

    /// Morphologies and their probabilities, most probable first.
    pub fn ranked(&self) -> &[(Morphology, f64)] {
        self.0.ranked()
    }

    /// The most probable morphology of the most probable set of damaged legs: which
    /// links of a leg are gone often leaves no trace, which legs are damaged does.
    pub fn best(&self) -> Option<&Morphology> {
        let legs = self.0.classes(Morphology::damaged_legs);
        let (likeliest, _) = legs.ranked().first()?;
        self.ranked()
            .iter()
            .map(|(morphology, _)| morphology)
            .find(|morphology| morphology.damaged_legs() == *likeliest)
    }

    /// Probability of each leg to miss a link.
    pub fn leg_damage(&self, legs: usize) -> Vec<f64> {
        (0..legs)
            .map(|leg| self.sum(|morphology| !is_whole(morphology, leg)))
            .collect()
    }

    /// Probability of each link to be gone, leg by leg from the body outward.
    pub fn link_loss(&self, links: impl IntoIterator<Item = usize>) -> Vec<Vec<f64>> {
        links
            .into_iter()
            .enumerate()
            .map(|(leg, count)| {
                (0..count)
                    .map(|link| self.sum(|morphology| morphology.remaining(leg) <= link))
                    .collect()
            })
            .collect()
    }

    /// The fewest morphologies that together hold this share of the probability.
    pub fn credible(&self, share: f64) -> Vec<&Morphology> {
        self.0.credible(share)
    }

    /// Probability of a morphology.
    pub fn of(&self, morphology: &Morphology) -> f64 {
        self.sum(|other| other == morphology)
    }

    /// Probability that exactly these legs, by their numbers, are damaged.
    pub fn of_legs(&self, damaged_legs: &[usize]) -> f64 {
        self.sum(|morphology| morphology.damaged_legs() == damaged_legs)
    }

    fn sum(&self, condition: impl Fn(&Morphology) -> bool) -> f64 {
        self.0.sum(condition)
    }
}

/// Mixture of a posterior over morphologies and, for the case that something else than damage
/// decides how the robot walks, a prior: the log then gives no evidence about legs.
#[derive(Debug, Clone, PartialEq)]
pub struct Belief {
    /// The posterior if one of the morphologies is right.
    pub posterior: Posterior,
    /// The prior of robots whose walk no morphology explains.
    pub unexplained: DamagePrior,
    /// Probability that something else decides how the robot walks.
    pub something_else: f64,
}

impl Belief {
    /// Probability of a morphology.
    pub fn of(&self, morphology: &Morphology) -> f64 {
        self.mixed(
            self.posterior.of(morphology),
            self.unexplained.ln(morphology).exp(),
        )
    }

    /// Probability that exactly the damaged legs of `morphology` are damaged.
    pub fn of_legs_of(&self, morphology: &Morphology) -> f64 {
        let damaged = morphology.damaged_legs();
        self.mixed(
            self.posterior.of_legs(&damaged),
            self.unexplained.of_legs(damaged.len(), morphology.legs()),
        )
    }

    /// Probability of each of so many legs to miss a link.
    pub fn leg_damage(&self, legs: usize) -> Vec<f64> {
        let damage = self.posterior.leg_damage(legs).into_iter();
        damage
            .map(|probability| self.mixed(probability, self.unexplained.leg_damaged))
            .collect()
    }

    /// Probability of each link to be gone, leg by leg from the body outward.
    pub fn link_loss(&self, links: impl IntoIterator<Item = usize>) -> Vec<Vec<f64>> {
        let loss = self.posterior.link_loss(links).into_iter();
        loss.map(|leg| {
            let unexplained = self.unexplained.link_loss(leg.len());
            let pairs = leg.into_iter().zip(unexplained);
            pairs
                .map(|(explained, unexplained)| self.mixed(explained, unexplained))
                .collect()
        })
        .collect()
    }

    fn mixed(&self, explained: f64, unexplained: f64) -> f64 {
        (1.0 - self.something_else) * explained + self.something_else * unexplained
    }
}

fn is_whole(morphology: &Morphology, leg: usize) -> bool {
    morphology.remaining(leg) == morphology.links(leg)
}

#[cfg(test)]
mod tests {
    use mlr_model::LegLayout;
    use proptest::prelude::*;

    use super::*;

    fn hexapod(text: &str) -> Morphology {
        Morphology::parse(text, &LegLayout::new([3; 6]).unwrap()).unwrap()
    }

    #[test]
    fn legs_are_decided_before_links() {
        let healthy = hexapod("111 111 111 111 111 111");
        let posterior = Posterior::new([
            (healthy.clone(), 0.4_f64.ln()),
            (hexapod("111 111 000 111 111 111"), 0.3_f64.ln()),
            (hexapod("111 111 100 111 111 111"), 0.3_f64.ln()),
        ]);
        assert_eq!(posterior.ranked()[0].0, healthy);
        assert_eq!(posterior.best().unwrap().damaged_legs(), [3]);
        assert!((posterior.of_legs(&[3]) - 0.6).abs() < 1e-12);
        let legs = posterior.leg_damage(6);
        assert!((legs[2] - 0.6).abs() < 1e-12 && legs[0] == 0.0);
        let links = posterior.link_loss([3; 6]);
        assert!((links[2][0] - 0.3).abs() < 1e-12 && (links[2][1] - 0.6).abs() < 1e-12);
        assert_eq!(posterior.credible(0.5).len(), 2);
    }

    #[test]
    fn what_nothing_explains_leaves_what_is_known_of_such_robots() {
        let healthy = hexapod("111 111 111 111 111 111");
        let posterior = Posterior::new([(healthy.clone(), 0.0)]);
        let prior = DamagePrior::default();
        let belief = |something_else| Belief {
            posterior: posterior.clone(),
            unexplained: prior,
            something_else,
        };
        assert_eq!(belief(0.0).leg_damage(6), [0.0; 6]);
        assert_eq!(belief(0.0).of(&healthy), 1.0);
        let lost = belief(1.0);
        assert!(
            lost.leg_damage(6)
                .iter()
                .all(|p| (p - prior.leg_damaged).abs() < 1e-12)
        );
        assert!((lost.of_legs_of(&healthy) - prior.of_legs(0, 6)).abs() < 1e-12);
        let half = belief(0.5);
        let expected = 0.5 + 0.5 * prior.of_legs(0, 6);
        assert!((half.of_legs_of(&healthy) - expected).abs() < 1e-12);
        assert!((half.link_loss([3; 6])[0][2] - 0.5 * prior.leg_damaged).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn probabilities_add_up_and_do_not_depend_on_order_or_constant(
            ln_weights in prop::collection::vec(-2000.0..2000.0_f64, 1..200),
            constant in -500.0..500.0_f64,
        ) {
            let all: Vec<Morphology> = LegLayout::new([3; 6]).unwrap().enumerate().collect();
            let pairs: Vec<_> = all.iter().cloned().zip(ln_weights.iter().copied()).collect();
            let posterior = Posterior::new(pairs.clone());
            let total: f64 = posterior.ranked().iter().map(|(_, p)| p).sum();
            prop_assert!((total - 1.0).abs() < 1e-9);
            let shifted = Posterior::new(pairs.iter().rev().map(|(m, w)| (m.clone(), w + constant)));
            for ((m, p), (n, q)) in posterior.ranked().iter().zip(shifted.ranked()) {
                prop_assert!(m == n && (p - q).abs() < 1e-9);
            }
            prop_assert!(posterior.credible(0.95).len() <= ln_weights.len());
        }
    }
}
