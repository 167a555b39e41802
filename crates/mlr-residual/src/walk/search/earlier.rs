//! What was found of a robot in another log.

use std::collections::BTreeMap;

use super::prior::EffectPrior;

/// What an explanation of another log says of the effects of the same robot on the same day: the probability
/// of each set of kinds. Where they are and how large is found anew.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct EarlierEffects {
    /// By the kinds in alphabetical order; one kind may be there several times.
    sets: BTreeMap<Vec<String>, f64>,
}

/// All sets that another log does not speak of have this probability together, at least.
const LEAST_OF_OTHERS: f64 = 0.01;

impl EarlierEffects {
    /// The kinds of each hypothesis, in any order, and its probability. Those with the same kinds add up.
    pub fn new(hypotheses: impl IntoIterator<Item = (Vec<String>, f64)>) -> Self {
        let mut sets = BTreeMap::new();
        for (mut kinds, probability) in hypotheses {
            kinds.sort();
            *sets.entry(kinds).or_insert(0.0) += probability.max(0.0);
        }
        Self { sets }
    }

    /// Logarithm of the probability of these kinds by the other log, over that before any log, of so many
    /// kinds in question.
    pub(super) fn ln_factor(
        &self,
        mut kinds: Vec<String>,
        prior: &EffectPrior,
        count: usize,
    ) -> f64 {
        let before = |kinds: &[String]| ln_kinds(kinds, prior, count).exp();
        let listed: f64 = self.sets.values().sum();
        let others = (1.0 - listed).max(LEAST_OF_OTHERS);
        let all = listed + others;
        kinds.sort();
        match self.sets.get(&kinds) {
            Some(probability) => (probability / all / before(&kinds)).ln(),
            None => {
                let listed_before: f64 = self.sets.keys().map(|set| before(set)).sum();
                (others / all / (1.0 - listed_before)).ln()
            }
        }
    }
}

/// Logarithm of the prior probability of exactly these kinds, in order, of so many in question, wherever they
/// are.
fn ln_kinds(kinds: &[String], prior: &EffectPrior, count: usize) -> f64 {
    let ln_factorial = |n: usize| (1..=n).map(|k| (k as f64).ln()).sum::<f64>();
    let alike = kinds.chunk_by(|a, b| a == b);
    let alike: f64 = alike.map(|same| ln_factorial(same.len())).sum();
    prior.ln_number(kinds.len()) + ln_factorial(kinds.len())
        - alike
        - kinds.len() as f64 * (count as f64).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNT: usize = 19;

    fn set(kinds: &[&str]) -> Vec<String> {
        kinds.iter().map(|kind| (*kind).into()).collect()
    }

    /// What is left of the prior after the other log.
    fn after(earlier: &EarlierEffects, kinds: &[&str]) -> f64 {
        let prior = EffectPrior::default();
        let ln = ln_kinds(&set(kinds), &prior, COUNT);
        (ln + earlier.ln_factor(set(kinds), &prior, COUNT)).exp()
    }

    #[test]
    fn the_answer_of_the_other_log_is_the_prior_of_this_one() {
        let earlier = EarlierEffects::new([
            (set(&["slope"]), 0.3),
            (set(&["imu_misalignment"]), 0.5),
            (set(&["weak_leg", "slope"]), 0.1),
            (set(&["slope"]), 0.05),
        ]);
        assert!((after(&earlier, &["slope"]) - 0.35).abs() < 1e-12);
        assert!((after(&earlier, &["imu_misalignment"]) - 0.5).abs() < 1e-12);
        assert!((after(&earlier, &["slope", "weak_leg"]) - 0.1).abs() < 1e-12);
        // The others share the rest as before any log.
        let (none, payload) = (after(&earlier, &[]), after(&earlier, &["payload"]));
        let prior = EffectPrior::default();
        let before =
            (ln_kinds(&[], &prior, COUNT) - ln_kinds(&set(&["payload"]), &prior, COUNT)).exp();
        assert!((none / payload / before - 1.0).abs() < 1e-9);
        assert!(none < 0.05);
    }

    #[test]
    fn a_log_that_said_nothing_changes_nothing_and_a_sure_one_leaves_a_doubt() {
        let prior = EffectPrior::default();
        let nothing = EarlierEffects::default();
        for kinds in [set(&[]), set(&["slope"])] {
            assert!(nothing.ln_factor(kinds, &prior, COUNT).abs() < 1e-12);
        }
        let sure = EarlierEffects::new([(set(&["slope"]), 1.0)]);
        assert!((after(&sure, &["slope"]) - 1.0 / 1.01).abs() < 1e-12);
        assert!(after(&sure, &["payload"]) > 1e-6);
    }
}
