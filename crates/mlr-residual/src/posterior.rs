//! Probabilities of hypotheses that exclude each other.

/// Hypotheses and their probabilities, most probable first. What is not among them is held to be
/// impossible.
#[derive(Debug, Clone, PartialEq)]
pub struct Posterior<T> {
    ranked: Vec<(T, f64)>,
}

/// Logarithm of the mean of so many numbers by their logarithms. Those not given are negligible;
/// minus infinity where all are.
pub fn ln_mean(ln_numbers: impl Iterator<Item = f64> + Clone, count: usize) -> f64 {
    ln_sum(ln_numbers) - (count as f64).ln()
}

/// Logarithm of the sum of numbers by their logarithms; minus infinity where all are negligible.
pub(crate) fn ln_sum(ln_numbers: impl Iterator<Item = f64> + Clone) -> f64 {
    let greatest = ln_numbers.clone().fold(f64::NEG_INFINITY, f64::max);
    if !greatest.is_finite() {
        return f64::NEG_INFINITY;
    }
    let sum: f64 = ln_numbers.map(|ln| (ln - greatest).exp()).sum();
    greatest + sum.ln()
}

impl<T> Posterior<T> {
    /// Normalises logarithms of likelihood times prior. Of equals, the first stays first.
    pub fn new(ln_weights: impl IntoIterator<Item = (T, f64)>) -> Self {
        let mut ranked: Vec<(T, f64)> = ln_weights
            .into_iter()
            .filter(|(_, ln_weight)| ln_weight.is_finite())
            .collect();
        ranked.sort_by(|(_, ln_a), (_, ln_b)| ln_b.total_cmp(ln_a));
        let greatest = ranked.first().map_or(0.0, |(_, ln_weight)| *ln_weight);
        for (_, weight) in &mut ranked {
            *weight = (*weight - greatest).exp();
        }
        let total: f64 = ranked.iter().map(|(_, weight)| weight).sum();
        for (_, weight) in &mut ranked {
            *weight /= total;
        }
        Self { ranked }
    }

    /// Hypotheses and their probabilities, most probable first.
    pub fn ranked(&self) -> &[(T, f64)] {
        &self.ranked
    }

    /// The fewest hypotheses that together hold this share of the probability.
    pub fn credible(&self, share: f64) -> Vec<&T> {
        let mut sum = 0.0;
        self.ranked
            .iter()
            .take_while(|(_, probability)| {
                let wanted = sum < share;
                sum += probability;
                wanted
            })
            .map(|(hypothesis, _)| hypothesis)
            .collect()
    }

    /// Probability that a hypothesis fulfils a condition.
    pub fn sum(&self, condition: impl Fn(&T) -> bool) -> f64 {
        self.ranked
            .iter()
            .filter(|(hypothesis, _)| condition(hypothesis))
            .map(|(_, probability)| probability)
            .sum()
    }
}

impl<T> Posterior<T> {
    /// The distribution of what hypotheses have in common: the probabilities of all of the same
    /// class are added up.
    pub fn classes<C: PartialEq>(&self, class: impl Fn(&T) -> C) -> Posterior<C> {
        let mut classes: Vec<(C, f64)> = Vec::new();
        for (hypothesis, probability) in &self.ranked {
            let of = class(hypothesis);
            match classes.iter_mut().find(|(known, _)| *known == of) {
                Some((_, sum)) => *sum += probability,
                None => classes.push((of, *probability)),
            }
        }
        classes.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        Posterior { ranked: classes }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn probabilities_add_up_whatever_the_order_and_the_constant(
            ln_weights in prop::collection::vec(-2000.0..2000.0_f64, 1..100),
            constant in -500.0..500.0_f64,
        ) {
            let posterior = Posterior::new(ln_weights.iter().copied().enumerate());
            let total: f64 = posterior.ranked().iter().map(|(_, p)| p).sum();
            prop_assert!((total - 1.0).abs() < 1e-9);
            let shifted = ln_weights.iter().map(|ln| ln + constant).enumerate();
            for (a, b) in posterior.ranked().iter().zip(Posterior::new(shifted).ranked()) {
                prop_assert!((a.1 - b.1).abs() < 1e-9);
            }
            prop_assert!(posterior.credible(0.9).len() <= ln_weights.len());
            let parities = posterior.classes(|k| k % 2);
            prop_assert!((parities.ranked().iter().map(|(_, p)| p).sum::<f64>() - 1.0).abs() < 1e-9);
            prop_assert!((posterior.sum(|k| k % 2 == 0) - parities.sum(|parity| *parity == 0)).abs() < 1e-9);
        }
    }

    #[test]
    fn the_credible_set_is_the_smallest_that_holds_its_share() {
        let posterior = Posterior::new([
            ("a", 0.6_f64.ln()),
            ("b", 0.3_f64.ln()),
            ("c", 0.1_f64.ln()),
        ]);
        assert_eq!(posterior.credible(0.5), [&"a"]);
        assert_eq!(posterior.credible(0.85), [&"a", &"b"]);
        assert_eq!(posterior.credible(0.95).len(), 3);
        assert!(
            Posterior::new([("a", f64::NAN), ("b", f64::NEG_INFINITY)])
                .ranked()
                .is_empty()
        );
    }
}
