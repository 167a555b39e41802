//! The search for effects: all at once, then one less at a time, as long as the evidence grows.

use rayon::prelude::*;

use super::{
    ServoError, ServoExplanation, ServoModel, ServoRecording, ServoSettings,
    evidence::{Fit, Promise, likeliest},
    hypothesis::Hypothesis,
    report,
};
use crate::{Progress, servo_effects::ServoEffect};

/// Sets that are fitted in a round, of those whose linear models promise most.
const FITTED: usize = 2;
/// Steps of a fit at most: of one that others follow upon, and of one that counts.
const FIRST_STEPS: usize = 4;
const STEPS: usize = 12;

/// What a search found.
pub(super) struct Found<'a> {
    /// The most probable set of effects.
    pub(super) best: Fit<'a>,
    /// The servo without effects, and with one after the other of the most probable set.
    pub(super) steps: Vec<Fit<'a>>,
    /// Sets of effects that were fitted, with the logarithm of evidence times prior.
    pub(super) fitted: Vec<(Vec<&'static str>, f64)>,
    /// Effects that were tried last beside the most probable set, with what their evidence adds.
    pub(super) tried: Vec<(&'static dyn ServoEffect, f64)>,
}

/// Finds what a servo has that its data sheet lacks.
///
/// 1. **Residual.** The bench of the data sheet is simulated with the goals of every recording.
/// 2. **Effects.** All effects of the library are fitted together. Then one is left out at a time, as long
///    as evidence times prior grows, and those that were left out are tried again. A search that begins
///    without effects ends with less evidence: while friction is missing, whatever slows the joint stands
///    in for it.
/// 3. **Before and after.** The error on recordings that neither fit nor choice has seen, `unseen`,
///    is measured at the end.
///
/// # Errors
/// [`ServoError`] with the index of the recording, of `fitted` and `unseen` in a row, and what is wrong
/// with it.
pub fn explain_servo(
    described: &ServoModel,
    fitted: &[ServoRecording],
    unseen: &[ServoRecording],
    settings: &ServoSettings,
    progress: &dyn Progress,
) -> Result<ServoExplanation, (usize, ServoError)> {
    for (index, recording) in fitted.iter().chain(unseen).enumerate() {
        let checked = recording.check().and_then(|()| {
            let gains = !recording.p_gain.is_empty();
            if gains && described.bench.reference.p_gain.is_none() {
                return Err(ServoError::GainWithoutReference);
            }
            Ok(())
        });
        checked.map_err(|error| (index, error))?;
    }
    let bare = Hypothesis::new(described, fitted, Vec::new());
    let Some(bare) = Fit::from(bare, &nalgebra::DVector::zeros(0), 0) else {
        return Err((0, ServoError::Diverged));
    };
    let search = Search {
        candidates: settings.candidates(&described.bench, fitted),
        progress,
    };
    let mut found = search.all(bare);
    if settings.effects.is_none() {
        search.settle(&mut found);
    }
    search.order(&mut found);
    if settings.effects.is_none() {
        found.keep_likeliest();
    }
    report::explanation(described, fitted, unseen, &found)
}

struct Search<'p> {
    candidates: Vec<&'static dyn ServoEffect>,
    progress: &'p dyn Progress,
}

impl Search<'_> {
    /// All candidates at once, one fitted beside the other in the order of the library.
    fn all<'a>(&self, bare: Fit<'a>) -> Found<'a> {
        let mut best = bare.clone();
        self.progress.expect_more(self.candidates.len());
        for effect in &self.candidates {
            let promise = best_start(&best, *effect);
            if let Some(fit) = promise.and_then(|promise| promise.fitted(FIRST_STEPS)) {
                best = fit;
            }
            self.progress.advance();
        }
        Found {
            fitted: [&bare, &best].map(of_set).into(),
            steps: vec![bare],
            best,
            tried: Vec::new(),
        }
    }

    /// Leaves effects out, and tries them again, as long as the evidence grows.
    fn settle(&self, found: &mut Found<'_>) {
        loop {
            while self.with_one_fewer(found) {}
            if !self.with_one_more(found) {
                return;
            }
        }
    }

    fn with_one_fewer(&self, found: &mut Found<'_>) -> bool {
        let effects = &found.best.hypothesis.effects;
        let needed = |kind| effects.iter().any(|other| other.builds_on() == Some(kind));
        let possible = (0..effects.len()).filter(|k| !needed(effects[*k].kind()));
        let possible: Vec<usize> = possible.collect();
        let promises = possible.into_par_iter();
        let promises = promises.filter_map(|left_out| found.best.promise_without(left_out));
        let promises: Vec<Promise<'_>> = promises.collect();
        let fits = self.most_promising(promises);
        found.take(fits)
    }

    fn with_one_more(&self, found: &mut Found<'_>) -> bool {
        let here = &found.best;
        let possible = self.candidates.par_iter().filter(|effect| {
            let there = |kind: &str| here.hypothesis.has(kind);
            !there(effect.kind()) && effect.builds_on().is_none_or(there)
        });
        let promises = possible.filter_map(|effect| best_start(here, *effect));
        let fits = self.most_promising(promises.collect());
        found.tried = fits
            .iter()
            .filter_map(|fit| {
                let added = fit.hypothesis.effects.last()?;
                Some((*added, fit.ln_weight - here.ln_weight))
            })
            .collect();
        found.take(fits)
    }

    fn most_promising<'a>(&self, mut promises: Vec<Promise<'a>>) -> Vec<Fit<'a>> {
        promises.sort_by(|a, b| b.ln_weight.total_cmp(&a.ln_weight));
        promises.truncate(FITTED);
        self.progress.expect_more(promises.len());
        let fits = promises.into_par_iter().filter_map(|promise| {
            let fit = promise.fitted(STEPS);
            self.progress.advance();
            fit
        });
        fits.collect()
    }

    /// In which order the effects of the most probable set enter, the one with the greatest evidence
    /// first, each beside those that are there already.
    fn order(&self, found: &mut Found<'_>) {
        let best = &found.best;
        let ranges = best.hypothesis.ranges();
        let mut left: Vec<usize> = (0..ranges.len()).collect();
        while let Some(here) = found.steps.last().filter(|_| !left.is_empty()) {
            let possible = left.par_iter().filter_map(|k| {
                let effect = best.hypothesis.effects[*k];
                let there = |kind: &str| here.hypothesis.has(kind);
                if !effect.builds_on().is_none_or(there) {
                    return None;
                }
                here.promise_with(effect, &best.z.as_slice()[ranges[*k].clone()])
            });
            let fits = self.most_promising(possible.collect());
            found.fitted.extend(fits.iter().map(of_set));
            let Some(next) = likeliest(fits) else {
                break;
            };
            left.retain(|k| !next.hypothesis.has(best.hypothesis.effects[*k].kind()));
            found.steps.push(next);
        }
    }
}

impl<'a> Found<'a> {
    /// Keeps the best of these fits if it is better, and says whether it was.
    fn take(&mut self, fits: Vec<Fit<'a>>) -> bool {
        self.fitted.extend(fits.iter().map(of_set));
        let better = likeliest(fits).filter(|fit| fit.ln_weight > self.best.ln_weight);
        let Some(better) = better else {
            return false;
        };
        self.best = better;
        true
    }

    /// Where the evidence is greatest before all effects have entered, the last ones stay out: fits that
    /// begin with few effects may end better.
    fn keep_likeliest(&mut self) {
        if let Some(step) = likeliest(self.steps.iter().cloned())
            && step.ln_weight > self.best.ln_weight
        {
            self.steps.truncate(step.hypothesis.effects.len() + 1);
            self.best = step;
        }
    }
}

/// The start of an effect, beside those that are there, that promises most.
fn best_start<'a>(here: &Fit<'a>, effect: &'static dyn ServoEffect) -> Option<Promise<'a>> {
    let parameters = effect.parameters(here.hypothesis.described()).len();
    let starts = effect.start_coordinates().iter();
    let promises = starts.filter_map(|start| here.promise_with(effect, &vec![*start; parameters]));
    promises.max_by(|a, b| a.ln_weight.total_cmp(&b.ln_weight))
}

fn of_set(fit: &Fit<'_>) -> (Vec<&'static str>, f64) {
    (fit.hypothesis.kinds(), fit.ln_weight)
}
