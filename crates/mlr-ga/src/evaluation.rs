//! Evaluations of candidate morphologies, and a cache of their results.

use std::collections::{BTreeMap, BTreeSet};

use mlr_model::Morphology;
use rayon::prelude::*;

use crate::{comparison::Misfit, walks::Case};

/// Something to minimise over morphologies.
pub trait Objective: Sync {
    /// Evaluates one candidate. Called from many threads at once; the same
    /// candidate must always give the same result. A candidate that turns out to
    /// cost more than `limit_deg` may be abandoned.
    fn evaluate(&self, candidate: &Morphology, limit_deg: f64) -> Evaluation;
}

/// The result of evaluating one morphology.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// The cost; infinite when the simulation diverged or was abandoned.
    pub cost_deg: f64,
    /// How well each case fits that was simulated to the end.
    pub fits: Vec<CaseFit>,
    /// Whether it was abandoned as too costly.
    pub abandoned: bool,
    /// Simulations that diverged.
    pub diverged: usize,
}

/// How well a candidate fits in one case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CaseFit {
    /// Which of the logs, counted from 0.
    pub log: usize,
    /// What its lost links are, and which variation of the model.
    pub case: Case,
    /// Sample of the simulated walk with which the measured one begins.
    pub offset: usize,
    /// The misfit.
    pub misfit: Misfit,
    /// Logarithm of the likelihood, up to a constant.
    pub ln_likelihood: f64,
}

/// Receives the progress of a search.
///
/// Whoever wants to end a search early unwinds from here with [`std::panic::resume_unwind`], and
/// catches that where the search was begun.
pub trait Progress: Sync {
    /// At most this many candidates will be evaluated in all.
    fn expect(&self, candidates: usize);
    /// This many more than expected before.
    fn expect_more(&self, candidates: usize);
    /// One more candidate has been evaluated.
    fn advance(&self);
}

/// Reports nothing.
impl Progress for () {
    fn expect(&self, _candidates: usize) {}
    fn expect_more(&self, _candidates: usize) {}
    fn advance(&self) {}
}

/// The progress of a search that is a part of something longer: what it expects is expected beside
/// the rest.
pub(crate) struct PartOf<'a, P>(pub(crate) &'a P);

impl<P: Progress> Progress for PartOf<'_, P> {
    fn expect(&self, candidates: usize) {
        self.0.expect_more(candidates);
    }

    fn expect_more(&self, candidates: usize) {
        self.0.expect_more(candidates);
    }

    fn advance(&self) {
        self.0.advance();
    }
}

/// Evaluates morphologies in parallel and remembers the results: no morphology
/// is evaluated twice.
pub struct Evaluations<'a> {
    objective: &'a dyn Objective,
    progress: &'a dyn Progress,
    known: BTreeMap<Morphology, Evaluation>,
}

impl<'a> Evaluations<'a> {
    /// Nothing evaluated yet.
    pub fn new(objective: &'a dyn Objective, progress: &'a dyn Progress) -> Self {
        Self {
            objective,
            progress,
            known: BTreeMap::new(),
        }
    }

    /// Evaluates those of the candidates that are not known yet, in parallel.
    pub fn evaluate(&mut self, candidates: &[Morphology]) {
        self.evaluate_within(candidates, f64::INFINITY);
    }

    /// The same, but abandons those that cost more than `limit_deg`.
    pub fn evaluate_within(&mut self, candidates: &[Morphology], limit_deg: f64) {
        let mut new: Vec<&Morphology> = candidates
            .iter()
            .filter(|candidate| !self.known.contains_key(candidate))
            .collect();
        new.sort_unstable();
        new.dedup();
        let results: Vec<Evaluation> = new
            .par_iter()
            .map(|candidate| {
                let evaluation = self.objective.evaluate(candidate, limit_deg);
                self.progress.advance();
                evaluation
            })
            .collect();
        self.known.extend(new.into_iter().cloned().zip(results));
    }

    /// Where progress is reported to.
    pub fn progress(&self) -> &'a dyn Progress {
        self.progress
    }

    /// What is known about a candidate.
    pub fn get(&self, candidate: &Morphology) -> Option<&Evaluation> {
        self.known.get(candidate)
    }

    /// Whether the candidate has been evaluated.
    pub fn contains(&self, candidate: &Morphology) -> bool {
        self.known.contains_key(candidate)
    }

    /// How many morphologies have been evaluated.
    pub fn len(&self) -> usize {
        self.known.len()
    }

    /// Whether nothing has been evaluated.
    pub fn is_empty(&self) -> bool {
        self.known.is_empty()
    }

    /// Simulations that diverged, over all candidates.
    pub fn diverged(&self) -> usize {
        self.known
            .values()
            .map(|evaluation| evaluation.diverged)
            .sum()
    }

    /// The evaluated morphologies, best first.
    pub fn ranking(&self) -> Vec<(&Morphology, &Evaluation)> {
        let mut ranking: Vec<_> = self.known.iter().collect();
        ranking.sort_by(|(a, _), (b, _)| self.order(a, b));
        ranking
    }

    /// Of every set of damaged legs the best morphology, best first.
    pub fn nearest_of_legs(&self) -> Vec<Morphology> {
        let mut seen = BTreeSet::new();
        let ranking = self.ranking().into_iter().map(|(morphology, _)| morphology);
        let nearest = ranking.filter(|morphology| seen.insert(morphology.damaged_legs()));
        nearest.cloned().collect()
    }

    /// Orders two evaluated candidates, the better first: by cost, at equal cost
    /// by the number of lost links (the simpler explanation), then by the
    /// vectors themselves. A candidate not evaluated counts as worst.
    pub fn order(&self, a: &Morphology, b: &Morphology) -> std::cmp::Ordering {
        let cost = |m| self.get(m).map_or(f64::INFINITY, |e| e.cost_deg);
        cost(a)
            .total_cmp(&cost(b))
            .then_with(|| lost_links(a).cmp(&lost_links(b)))
            .then_with(|| b.cmp(a))
    }

    /// The best morphology evaluated so far.
    pub fn best(&self) -> Option<(&Morphology, &Evaluation)> {
        self.known.iter().min_by(|(a, _), (b, _)| self.order(a, b))
    }
}

fn lost_links(morphology: &Morphology) -> usize {
    (0..morphology.legs())
        .map(|leg| morphology.links(leg) - morphology.remaining(leg))
        .sum()
}

#[cfg(test)]
pub(crate) mod tests {
    use std::{
        panic::{AssertUnwindSafe, catch_unwind, resume_unwind},
        sync::atomic::{AtomicUsize, Ordering},
    };

    use mlr_model::LegLayout;

    use super::*;

    impl Evaluation {
        fn of_cost(cost_deg: f64) -> Self {
            Self {
                cost_deg,
                fits: Vec::new(),
                abandoned: false,
                diverged: 0,
            }
        }
    }

    /// Distance to a target, in links.
    pub(crate) struct Distance {
        pub(crate) target: Morphology,
        pub(crate) calls: AtomicUsize,
    }

    impl Distance {
        pub(crate) fn to(target: Morphology) -> Self {
            Self {
                target,
                calls: AtomicUsize::new(0),
            }
        }
    }

    impl Objective for Distance {
        fn evaluate(&self, candidate: &Morphology, _: f64) -> Evaluation {
            self.calls.fetch_add(1, Ordering::Relaxed);
            let distance: usize = (0..candidate.legs())
                .map(|leg| {
                    candidate
                        .remaining(leg)
                        .abs_diff(self.target.remaining(leg))
                })
                .sum();
            Evaluation::of_cost(distance as f64)
        }
    }

    #[test]
    fn nothing_is_evaluated_twice() {
        let layout = LegLayout::new([2, 2]).unwrap();
        let all: Vec<_> = layout.enumerate().collect();
        let objective = Distance::to(all[4].clone());
        let mut evaluations = Evaluations::new(&objective, &());
        evaluations.evaluate(&all[..6]);
        evaluations.evaluate(&all);
        evaluations.evaluate(&[all[0].clone(), all[0].clone()]);
        assert_eq!(objective.calls.load(Ordering::Relaxed), all.len());
        assert_eq!(evaluations.len(), all.len());
        assert_eq!(evaluations.best().unwrap().0, &all[4]);
    }

    #[test]
    fn of_each_set_of_damaged_legs_the_nearest_is_kept() {
        let layout = LegLayout::new([2, 2]).unwrap();
        let remaining = |legs: [usize; 2]| {
            let healthy = Morphology::healthy(&layout);
            healthy
                .with_remaining(0, legs[0])
                .with_remaining(1, legs[1])
        };
        let objective = Distance::to(remaining([1, 2]));
        let mut evaluations = Evaluations::new(&objective, &());
        evaluations.evaluate(&layout.enumerate().collect::<Vec<_>>());
        // At equal distance fewer lost links come first.
        let nearest = [[1, 2], [2, 2], [1, 1], [2, 1]].map(remaining);
        assert_eq!(evaluations.nearest_of_legs(), nearest);
    }

    #[test]
    fn a_progress_that_unwinds_ends_the_evaluation() {
        struct Enough;
        struct GiveUp(AtomicUsize);
        impl Progress for GiveUp {
            fn expect(&self, _: usize) {}
            fn expect_more(&self, _: usize) {}
            fn advance(&self) {
                if self.0.fetch_add(1, Ordering::Relaxed) >= 3 {
                    resume_unwind(Box::new(Enough));
                }
            }
        }
        let layout = LegLayout::new([3; 6]).unwrap();
        let all: Vec<_> = layout.enumerate().collect();
        let objective = Distance::to(all[4].clone());
        let progress = GiveUp(AtomicUsize::new(0));
        let unwound = catch_unwind(AssertUnwindSafe(|| {
            Evaluations::new(&objective, &progress).evaluate(&all);
        }));
        assert!(unwound.unwrap_err().is::<Enough>());
        // What other threads had begun was finished.
        assert!(objective.calls.load(Ordering::Relaxed) < all.len());
    }

    #[test]
    fn a_part_adds_to_what_is_expected_of_the_whole() {
        #[derive(Default)]
        struct Whole(AtomicUsize);
        impl Progress for Whole {
            fn expect(&self, candidates: usize) {
                self.0.store(candidates, Ordering::Relaxed);
            }
            fn expect_more(&self, candidates: usize) {
                self.0.fetch_add(candidates, Ordering::Relaxed);
            }
            fn advance(&self) {}
        }
        let whole = Whole::default();
        whole.expect(4);
        PartOf(&whole).expect(3);
        PartOf(&whole).expect_more(2);
        assert_eq!(whole.0.load(Ordering::Relaxed), 9);
    }

    #[test]
    fn at_equal_cost_the_lesser_damage_is_better() {
        struct Indifferent;
        impl Objective for Indifferent {
            fn evaluate(&self, _: &Morphology, _: f64) -> Evaluation {
                Evaluation::of_cost(0.0)
            }
        }
        let layout = LegLayout::new([3; 6]).unwrap();
        let all: Vec<_> = layout.enumerate().collect();
        let mut evaluations = Evaluations::new(&Indifferent, &());
        evaluations.evaluate(&all);
        assert!(evaluations.best().unwrap().0.is_healthy());
        assert_eq!(evaluations.ranking().len(), all.len());
    }
}
