//! What hypotheses promise by single walks, on robots whose sensitivities were not computed.

use nalgebra::DVector;
use rayon::prelude::*;

use super::{Search, base::Base, extrapolation::Simulated};
use crate::walk::{evidence::Fit, hypothesis::Walker};

/// A hypothesis, by a single walk.
pub(super) struct Promise<'b, 'a> {
    /// It is taken to be as sensitive as this robot to what robots of one make differ by, and to err as much.
    like: &'b Base<'a>,
    /// Logarithm of the prior probability of its own robot.
    pub(super) ln_robot: f64,
    pub(super) walker: Walker<'a>,
    /// The likeliest point that was walked.
    z: DVector<f64>,
    /// Logarithm of its weight by that walk.
    pub(super) ln_weight: f64,
}

/// A promise that was fitted by sensitivities of its own.
pub(super) struct Kept<'a> {
    pub(super) ln_robot: f64,
    pub(super) walker: Walker<'a>,
    pub(super) fit: Fit,
    /// Logarithm of its weight by the fit.
    pub(super) ln_weight: f64,
}

impl<'a> Search<'a, '_> {
    /// What a hypothesis promises by a single walk from each of these points. `None` where none walks.
    pub(super) fn promise<'b>(
        &self,
        like: &'b Base<'a>,
        ln_robot: f64,
        walker: Walker<'a>,
        points: impl IntoIterator<Item = DVector<f64>>,
    ) -> Option<Promise<'b, 'a>> {
        let jacobian = walker.with_slopes_of(&like.with(Vec::new()), &like.jacobian);
        let slopes = like.whitening.apply(&jacobian);
        let ln_evidences = points.into_iter().filter_map(|z| {
            let walked = walker.walk(z.clone())?;
            let simulated = Simulated::of(&walked, slopes.clone(), &like.whitening);
            let linear = simulated.with(&[], &walker, false);
            Some((linear.ln_evidence(&like.whitening).0, z))
        });
        let (ln_evidence, z) = ln_evidences.max_by(|(a, _), (b, _)| a.total_cmp(b))?;
        Some(Promise {
            like,
            ln_robot,
            ln_weight: ln_evidence + self.ln_prior(ln_robot, &walker),
            walker,
            z,
        })
    }

    /// The `most` promising of these, after so many steps at most, the likeliest first.
    pub(super) fn kept(
        &self,
        mut promises: Vec<Promise<'_, 'a>>,
        most: usize,
        steps: usize,
    ) -> Vec<Kept<'a>> {
        sort_promises(&mut promises);
        promises.truncate(most);
        self.progress.expect_more(promises.len());
        let kept = promises.into_par_iter().filter_map(|one| {
            let Promise {
                like,
                ln_robot,
                walker,
                z,
                ..
            } = one;
            let fit = walker.fitted(z, &like.whitening, steps);
            self.progress.advance();
            let fit = fit?;
            Some(Kept {
                ln_robot,
                ln_weight: fit.ln_evidence + self.ln_prior(ln_robot, &walker),
                walker,
                fit,
            })
        });
        let mut kept: Vec<Kept<'a>> = kept.collect();
        kept.sort_by(|a, b| b.ln_weight.total_cmp(&a.ln_weight));
        kept
    }
}

/// The most promising first.
pub(super) fn sort_promises(promises: &mut [Promise<'_, '_>]) {
    promises.sort_by(|a, b| b.ln_weight.total_cmp(&a.ln_weight));
}
