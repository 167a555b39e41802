//! Hypotheses that are not worth a fit: each is improbable, all of them together are not.

use std::sync::Arc;

use nalgebra::DVector;
use rayon::prelude::*;

use super::{
    Judged, Search,
    extrapolation::Simulated,
    proposals::Screened,
    screening::{Start, everywhere},
};
use crate::walk::{
    evidence::ln_evidence,
    hypothesis::{Placement, Walker},
};

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
                .find(|on| Arc::ptr_eq(&on.base, &judged.base));
            let of_whole = fitted.iter().filter(|one| {
                let hypothesis = one.hypothesis();
                hypothesis.is_same(judged.hypothesis())
            });
            let ln_whole = of_whole.map(|one| one.ln_weight).max_by(f64::total_cmp);
            let Some(ln_whole) = ln_whole else { continue };
            if let Some(on) = on {
                unfitted.extend(self.beside(on, judged, ln_whole));
            }
            unfitted.extend(self.hidden_beside(judged, ln_whole));
        }
        unfitted.sort_by(|a, b| b.ln_weight.total_cmp(&a.ln_weight));
        unfitted
    }

    /// A hypothesis with each effect that this record hides. It is as probable as it was before.
    fn hidden_beside(&self, judged: &Judged<'a>, ln_weight_without: f64) -> Vec<Unfitted<'a>> {
        let record = self.setting.observation.record;
        let everywhere = everywhere(self.setting, &judged.base.morphology).into_iter();
        let hidden = everywhere.filter(|placed| record.hides(placed.effect));
        let with = |placement: Placement| {
            let (walker, ln_prior) = self.with_one_more(judged, placement);
            let coordinates = judged.fit.walked.z.clone();
            Unfitted {
                coordinates: coordinates.resize_vertically(walker.dimension(), 0.0),
                walker,
                ln_weight: ln_weight_without + ln_prior,
            }
        };
        hidden.map(with).collect()
    }

    /// A hypothesis with one effect more, and the logarithm of its prior probability over that of the one without.
    fn with_one_more(&self, judged: &Judged<'a>, added: Placement) -> (Walker<'a>, f64) {
        let ln_prior = |walker: &Walker<'a>| self.ln_prior(judged.base.ln_prior, walker);
        let walker = judged.base.with_added(&judged.walker, added);
        let ln_ratio = ln_prior(&walker) - ln_prior(&judged.walker);
        (walker, ln_ratio)
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
        let simulated = Simulated::new(fit, &base.whitening);
        let with = |start: &Start| -> Unfitted<'a> {
            let (walker, ln_prior) = self.with_one_more(judged, start.placement);
            let linear = simulated.with(&[start], &walker, false);
            let (ln_with, mut coordinates) = linear.ln_evidence(&base.whitening);
            walker.clamp(&mut coordinates);
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

#[cfg(test)]
mod tests {
    use mlr_model::{Gait, LostLinks, Morphology, Robot, SimulationSettings};

    use super::*;
    use crate::walk::{
        WalkModel,
        record::tests::level_record_where,
        search::{base::Base, tests::with_search},
    };

    /// What the effects beside a robot without any have for weights, in units of that of the robot, where the record
    /// tells when the walk was commanded, or does not.
    fn hidden_beside_none(start_is_told: bool) -> Vec<(&'static str, f64)> {
        let record = level_record_where(start_is_told);
        let robot = Robot::jethexa();
        let healthy = Morphology::healthy(&robot.layout());
        let nominal = WalkModel::nominal(robot, Gait::tripod(), SimulationSettings::default());
        with_search(&record, &nominal, |search| {
            let base = Base::new(search.setting, &healthy, LostLinks::Absent, 0.0);
            let base = Arc::new(base.unwrap());
            let walker = base.with(Vec::new());
            let fit = base.fit(&walker);
            let bare = [search.judge(&base, walker, fit)];
            let hidden = search.unfitted(&[], &bare, &bare).into_iter().map(|one| {
                let kind = one.walker.hypothesis.effects[0].effect.kind();
                (kind, (one.ln_weight - bare[0].ln_weight).exp())
            });
            hidden.collect()
        })
    }

    #[test]
    fn a_delay_that_no_record_shows_is_as_probable_as_it_was() {
        let found = hidden_beside_none(false);
        let kinds: Vec<&str> = found.iter().map(|(kind, _)| *kind).collect();
        assert!(
            kinds.contains(&"servo_lag") && kinds.contains(&"sensor_delay"),
            "{kinds:?}"
        );
        // As probable as not that there is an effect, with 0.85 the only one, one of 10 kinds; bounds cut off a
        // twentieth of its prior.
        for (kind, share) in found {
            assert!((share / 0.085 - 1.0).abs() < 0.06, "{kind} {share}");
        }
        // The control: where it would show, it is not taken for granted.
        assert!(hidden_beside_none(true).is_empty());
    }
}
