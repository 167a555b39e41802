//! Hypotheses that are not worth a fit: each is improbable, all of them together are not.

use std::sync::Arc;

use nalgebra::DVector;
use rayon::prelude::*;

use super::{Judged, Search, extrapolation::Simulated, proposals::Screened, screening::Start};
use crate::walk::{evidence::ln_evidence, hypothesis::Walker};

/// A hypothesis that is weighed by its linear model.
#[derive(Debug, Clone)]
pub(crate) struct Unfitted<'a> {
    pub(crate) walker: Walker<'a>,
    /// Where the linear model is most probable.
    pub(crate) coordinates: DVector<f64>,
    /// Logarithm of evidence times prior probability.
    pub(crate) ln_weight: f64,
}

impl<'a> Search<'a, '_> {
    /// Each screened effect beside the likeliest hypotheses, `ranked` by the beginning of the walk and
    /// `fitted` over the whole stretch.
    ///
    /// An effect too small to be seen is as probable as its prior where the record cannot tell it from
    /// nothing. A linear model is no reason to hold it for likelier than that: what looked promising
    /// was fitted, and failed.
    pub(super) fn unfitted(
        &self,
        screened: &[Screened<'a>],
        ranked: &[Judged<'a>],
        fitted: &[Judged<'a>],
    ) -> Vec<Unfitted<'a>> {
        let mut unfitted: Vec<Unfitted<'a>> = Vec::new();
        let extended = ranked
            .iter()
            .filter(|one| (1..self.effort.most_effects).contains(&one.hypothesis().effects.len()));
        let bare = ranked.iter().filter(|one| one.hypothesis().is_bare());
        for judged in bare.chain(extended.take(self.effort.extended)) {
            let on = screened
                .iter()
                .find(|on| Arc::ptr_eq(&on.base, &judged.base) && on.base.only_leg.is_none());
            let of_whole = fitted.iter().filter(|one| {
                let hypothesis = one.hypothesis();
                hypothesis.is_same(judged.hypothesis())
            });
            let ln_whole = of_whole.map(|one| one.ln_weight).max_by(f64::total_cmp);
            if let (Some(on), Some(ln_whole)) = (on, ln_whole) {
                unfitted.extend(self.beside(on, judged, ln_whole));
            }
        }
        unfitted.sort_by(|a, b| b.ln_weight.total_cmp(&a.ln_weight));
        unfitted
    }

    fn beside(
        &self,
        on: &Screened<'a>,
        judged: &Judged<'a>,
        ln_weight_without: f64,
    ) -> Vec<Unfitted<'a>> {
        let base = &on.base;
        let fit = &judged.fit;
        let (ln_without, _) = ln_evidence(
            &base.whitening,
            &fit.walked.residual,
            &fit.walked.z,
            &fit.jacobian,
        );
        let known = &judged.hypothesis().effects;
        let prior_without = self.ln_prior(base.ln_prior, &judged.walker);
        let simulated = Simulated::new(fit, &base.whitening);
        let with = |start: &Start| -> Unfitted<'a> {
            let walker = base.with_added(&judged.walker, start.placement);
            let linear = simulated.with(&[start], &walker, false);
            let (ln_with, mut coordinates) = linear.ln_evidence(&base.whitening);
            walker.clamp(&mut coordinates);
            let ln_prior = self.ln_prior(base.ln_prior, &walker) - prior_without;
            Unfitted {
                walker,
                coordinates,
                ln_weight: ln_weight_without + ln_prior + (ln_with - ln_without).min(0.0),
            }
        };
        let starts = on.starts.par_iter();
        starts
            .filter(|start| !known.contains(&start.placement))
            .map(with)
            .collect()
    }
}
