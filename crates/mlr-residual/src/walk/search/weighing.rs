//! The final weights: evidence that no lucky walk decides.

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::{Judged, Search, least_ln_weight, race::likeliest, sort_judged};

/// Hypotheses with effects that are weighed so.
const MOST: usize = 8;
/// Fits of a robot without effects.
const BARE: usize = 2;

impl<'a> Search<'a, '_> {
    /// The likeliest hypotheses, each once, by the variational bound of their evidence. The others, which
    /// have fallen behind, lose as much as these do in the mean.
    pub(super) fn weighed(&self, mut fitted: Vec<Judged<'a>>) -> Vec<Judged<'a>> {
        sort_judged(&mut fitted);
        let mut apart: Vec<Judged<'a>> = Vec::new();
        for one in fitted {
            let hypothesis = &one.walker.hypothesis;
            let is_known = apart
                .iter()
                .any(|other| other.walker.hypothesis.is_same(hypothesis));
            if !is_known {
                apart.push(one);
            }
        }
        let least = least_ln_weight(&apart);
        let is_bare = |k: &usize| apart[*k].walker.hypothesis.is_bare();
        let bare = (0..apart.len()).filter(is_bare).take(BARE);
        let chosen: Vec<usize> = likeliest(&apart, MOST)
            .into_iter()
            .chain(bare)
            .filter(|k| apart[*k].ln_weight > least)
            .collect();
        self.progress.expect_more(chosen.len());
        // The same draws for all.
        let generator = ChaCha8Rng::seed_from_u64(0);
        let weighed: Vec<Judged<'a>> = chosen
            .par_iter()
            .map(|k| {
                let Judged {
                    base, walker, fit, ..
                } = &apart[*k];
                let fit = walker.bounded(fit.clone(), &base.whitening, &generator);
                self.progress.advance();
                self.judge(base, walker.clone(), fit)
            })
            .collect();
        let changes = chosen
            .iter()
            .zip(&weighed)
            .map(|(k, weighed)| weighed.ln_weight - apart[*k].ln_weight)
            .filter(|change| change.is_finite());
        let (sum, count) = changes.fold((0.0, 0), |(sum, count), change| (sum + change, count + 1));
        let mean = sum / f64::from(count.max(1));
        let left = apart.into_iter().enumerate();
        let left = left.filter(|(k, _)| !chosen.contains(k));
        let left: Vec<Judged<'a>> = left
            .map(|(_, one)| Judged {
                ln_weight: one.ln_weight + mean,
                ..one
            })
            .collect();
        weighed.into_iter().chain(left).collect()
    }
}
