//! The likeliest hypotheses over the whole stretch.

use std::sync::Arc;

use nalgebra::DVector;
use rayon::prelude::*;

use super::{
    Judged, Search, base::Base, kept_bare, proposals::Screened, race::likeliest, screening,
    sort_judged, weighing::Weighed,
};
use crate::walk::{
    evidence::Fit,
    hypothesis::{Placement, Walker},
};

/// Hypotheses with effects that are fitted over the whole stretch.
const MOST: usize = 6;
/// Robots whose sensors' effects are screened over it: they grow with time.
const SCREENED: usize = 2;
/// Entrants of these.
const ENTRANTS: usize = 8;
/// Steps of a fit, at most.
const STEPS: usize = 2;

impl<'a> Search<'a, '_> {
    /// The likeliest of these, and effects of the sensor beside them, fitted over the whole stretch.
    pub(super) fn over_the_whole_stretch(&self, ranked: &[Judged<'a>]) -> Vec<Judged<'a>> {
        let is_bare = |judged: &&Judged<'a>| judged.hypothesis().is_bare();
        let bare = kept_bare(ranked.iter().map(Judged::hypothesis))
            .into_iter()
            .map(|k| &ranked[k]);
        let with_effects = likeliest(ranked, MOST).into_iter().map(|k| &ranked[k]);
        let chosen: Vec<&Judged<'a>> = bare.chain(with_effects).collect();
        let mut bases: Vec<(Arc<Base<'a>>, Arc<Base<'a>>)> = Vec::new();
        for judged in &chosen {
            let is_known = bases
                .iter()
                .any(|(early, _)| Arc::ptr_eq(early, &judged.base));
            if is_known {
                continue;
            }
            // From where the race left it, if it took part.
            let raced = ranked
                .iter()
                .find(|one| is_bare(one) && Arc::ptr_eq(&one.base, &judged.base));
            let z = raced.map_or(&judged.base.reference.z, |one| &one.fit.walked.z);
            let whole = judged.base.continued(self.setting, z.clone());
            let whole = whole.and_then(|whole| whole.scattered(self.of_means, self.generator));
            if let Some(whole) = whole {
                bases.push((Arc::clone(&judged.base), Arc::new(whole)));
            }
        }
        let of = |early: &Arc<Base<'a>>| {
            let known = bases.iter().find(|(known, _)| Arc::ptr_eq(known, early));
            known.map(|(_, whole)| whole)
        };
        self.progress.expect_more(chosen.len());
        let mut running: Vec<Judged<'a>> = chosen
            .into_par_iter()
            .filter_map(|judged| {
                let base = of(&judged.base)?;
                let walker = base.with(judged.hypothesis().effects.clone());
                if judged.hypothesis().is_bare() {
                    let fit = base.fit(&walker);
                    self.progress.advance();
                    return Some(self.judge(base, walker, fit));
                }
                let z = &judged.fit.walked.z;
                // The body as it walked at first with these effects, as it is all along without them, or as described.
                let values = judged.walker.values(z);
                let starts = vec![
                    z.clone(),
                    base.beside_reference(&walker, &values),
                    walker.with_body_described(z.clone()),
                ];
                let judged = self.fitted_from(base, walker, starts);
                self.progress.advance();
                judged
            })
            .collect();
        sort_judged(&mut running);
        let screened: Vec<Screened<'a>> = bases
            .iter()
            .take(SCREENED)
            .map(|(_, whole)| Screened {
                starts: screening::starts_of_sensing(whole),
                base: Arc::clone(whole),
            })
            .collect();
        if self.effort.most_effects > 0 {
            running.extend(self.entrants(&screened, self.singles(&screened), ENTRANTS));
        }
        let mut ranked = self.each(running, |one| Some(self.advanced(one)));
        sort_judged(&mut ranked);
        let best = ranked.iter().find(|judged| !judged.hypothesis().is_bare());
        let with_fewer = best.map(|best| self.with_fewer_effects(best, |_| true));
        ranked.extend(with_fewer.into_iter().flatten());
        ranked
    }

    /// These hypotheses, and the likeliest one without each of its effects, as far as that was not weighed.
    pub(super) fn with_fewer_than_the_likeliest(&self, mut weighed: Weighed<'a>) -> Weighed<'a> {
        let all = weighed.all();
        let Some(likeliest) = all.first() else {
            return weighed;
        };
        if likeliest.hypothesis().effects.len() < 2 {
            return weighed;
        }
        let on_its_robot =
            |one: &&Judged<'a>| one.is_weighed() && Arc::ptr_eq(&one.base, &likeliest.base);
        let weighed_before: Vec<&[Placement]> = all
            .iter()
            .filter(on_its_robot)
            .map(|one| one.hypothesis().effects.as_slice())
            .collect();
        let is_new = |effects: &[Placement]| !weighed_before.contains(&effects);
        let fewer = self.with_fewer_effects(likeliest, is_new);
        self.progress.expect_more(fewer.len());
        self.weigh_too(&mut weighed, fewer, std::slice::from_ref(likeliest));
        weighed
    }

    /// A hypothesis without all of its effects, and without one of several, begun from the parameters
    /// that were found with them: effects get no credit for a better search of these.
    fn with_fewer_effects(
        &self,
        judged: &Judged<'a>,
        is_wanted: impl Fn(&[Placement]) -> bool,
    ) -> Vec<Judged<'a>> {
        let (base, known) = (&judged.base, &judged.walker);
        let z = &judged.fit.walked.z;
        let values = known.values(z);
        let count = values.len();
        let all_but = |left_out: usize| (0..count).filter(|k| *k != left_out).collect();
        let mut kept: Vec<Vec<usize>> = (0..count).map(all_but).collect();
        if count > 1 {
            kept.push(Vec::new());
        }
        let effects_of = |kept: &[usize]| -> Vec<Placement> {
            let each = kept.iter().map(|k| known.hypothesis.effects[*k]);
            each.collect()
        };
        kept.retain(|kept| is_wanted(&effects_of(kept)));
        self.progress.expect_more(kept.len());
        kept.into_par_iter()
            .filter_map(|kept| {
                let values: Vec<Vec<f64>> = kept.iter().map(|k| values[*k].clone()).collect();
                let walker = base.with(effects_of(&kept));
                let nuisances = z.rows(0, walker.nuisances()).clone_owned();
                let without = nuisances.resize_vertically(walker.dimension(), 0.0);
                let without = walker.with_values(without, &values);
                // The same with what the effect had in place of a parameter of the robot.
                let replaced = walker.with_parameters_of(known, z);
                let fitted = self.fitted_from(base, walker, vec![replaced, without]);
                self.progress.advance();
                fitted
            })
            .collect()
    }

    /// From the likeliest of these coordinates, so few steps on: the mean of its walks leads further.
    pub(super) fn fitted_from(
        &self,
        base: &Arc<Base<'a>>,
        walker: Walker<'a>,
        starts: Vec<DVector<f64>>,
    ) -> Option<Judged<'a>> {
        let start = walker.likelier(starts, &base.whitening)?;
        let Fit {
            walked, jacobian, ..
        } = walker.begun(start, &base.jacobian, &base.whitening);
        let fit = walker.advanced(walked, jacobian, &base.whitening, STEPS);
        Some(self.judge(base, walker, fit))
    }
}
