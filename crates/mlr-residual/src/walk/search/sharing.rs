//! What one hypothesis finds of a robot's own parameters, for every other on the same robot.

use std::sync::Arc;

use rayon::prelude::*;

use super::{Judged, Search, least_ln_weight, race::LAST_STEPS};

impl<'a> Search<'a, '_> {
    /// Each of these begun again from the parameters that the likeliest on the same robot has, where that
    /// leads further: a walk is no smooth function of all its parameters, and what one search has
    /// found by chance is no reason to believe its hypothesis.
    pub(super) fn with_shared_parameters(&self, running: &[Judged<'a>]) -> Vec<Judged<'a>> {
        self.progress.expect_more(running.len());
        let least = least_ln_weight(running);
        running
            .par_iter()
            .map(|one| {
                let may_win = one.ln_weight > least;
                let again = may_win.then(|| self.begun_like(one, running)).flatten();
                self.progress.advance();
                again.unwrap_or_else(|| one.clone())
            })
            .collect()
    }

    /// `None` where no other's parameters lead further.
    fn begun_like(&self, one: &Judged<'a>, running: &[Judged<'a>]) -> Option<Judged<'a>> {
        let alike = running
            .iter()
            .filter(|other| Arc::ptr_eq(&other.base, &one.base));
        let likeliest = alike.max_by(|a, b| a.fit.ln_evidence.total_cmp(&b.fit.ln_evidence))?;
        if likeliest.fit.ln_evidence <= one.fit.ln_evidence {
            return None;
        }
        let (base, walker) = (&one.base, &one.walker);
        let own = walker.nuisances();
        let theirs = &likeliest.fit.walked.z;
        // What an effect has in place of a parameter of the robot may be that parameter's, or more
        // than any robot's is.
        let replaced = walker.with_parameters_of(&likeliest.walker, theirs);
        let points = [replaced.rows(0, own), theirs.rows(0, own)].map(|parameters| {
            let mut z = one.fit.walked.z.clone();
            z.rows_mut(0, own).copy_from(&parameters);
            walker.clamp(&mut z);
            z
        });
        let walked = walker.likelier(points.into(), &base.whitening)?;
        let known = likeliest.fit.jacobian.columns(0, own).clone_owned();
        let begun = self.begun(base, walker.clone(), walked, &known);
        let fit = begun.fit;
        let fit = walker.advanced(fit.walked, fit.jacobian, &base.whitening, LAST_STEPS);
        let again = self.judge(base, walker.clone(), fit);
        (again.ln_weight > one.ln_weight).then_some(again)
    }
}
