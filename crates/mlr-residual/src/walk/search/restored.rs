//! Damaged legs taken for whole ones that effects are on: a leg that does not do its part passes for a lost one.

use std::sync::Arc;

use mlr_model::{LostLinks, Morphology};
use rayon::prelude::*;

use super::{Search, base::Base, proposals::Screened, screening::placements};
use crate::walk::hypothesis::{Hypothesis, Placement};

/// Robots with a leg restored on which effects are screened.
const MOST: usize = 4;

/// A robot with one leg more than a robot that it was taken for.
struct Restored<'b, 'a> {
    taken_for: &'b Base<'a>,
    morphology: Morphology,
    lost_links: LostLinks,
    /// Logarithm of its prior probability.
    ln_prior: f64,
    /// The leg, from 1, that an effect must be on: without one, this is another robot.
    leg: usize,
}

impl<'a> Search<'a, '_> {
    /// The most promising of these robots with one damaged leg restored, by a walk with each effect on that leg, as
    /// far as they may still win against `best`, the logarithm of the weight of the most promising effect so far. Of
    /// robots with the same damaged legs the first counts, whether these are gone or locked.
    ///
    /// They take no step more: without an effect on that leg, a robot that comes near the log is another one.
    pub(super) fn restored(
        &self,
        begun: &[Base<'a>],
        screened: &[Screened<'a>],
        best: f64,
    ) -> Vec<Arc<Base<'a>>> {
        let wanted = self.restored_of(begun, screened);
        self.progress.expect_more(wanted.len());
        let promising = wanted.into_par_iter().filter_map(|one| {
            let ln_promise = self.ln_promise_of(&one);
            self.progress.advance();
            let may_win = |promise: &f64| *promise >= best - self.hopeless();
            Some((ln_promise.filter(may_win)?, one))
        });
        let mut ranked: Vec<(f64, Restored<'_, 'a>)> = promising.collect();
        ranked.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        ranked.truncate(MOST);
        ranked
            .into_par_iter()
            .filter_map(|(_, one)| {
                let Restored {
                    morphology,
                    lost_links,
                    ln_prior,
                    leg,
                    ..
                } = one;
                Base::new(self.beginning, &morphology, lost_links, ln_prior, Some(leg))?
                    .scattered(self.beginning_of_means, self.generator)
                    .map(Arc::new)
            })
            .collect()
    }

    /// Logarithm of the weight of the most probable effect on the restored leg by a single walk of each: it is as
    /// sensitive to what robots of one make differ by as that of the robot it was taken for, and errs as much. `None`
    /// where no such robot walks.
    fn ln_promise_of(&self, restored: &Restored<'_, 'a>) -> Option<f64> {
        let (morphology, lost_links) = (&restored.morphology, restored.lost_links);
        let placements = placements(self.beginning, morphology, Some(restored.leg));
        let each = placements
            .into_par_iter()
            .filter_map(|placement| self.ln_evidence_of_single(restored, placement));
        let best = each.reduce(|| f64::NEG_INFINITY, f64::max);
        let ln_prior = restored.ln_prior + self.prior.ln_lost_links(morphology, lost_links);
        best.is_finite().then_some(best + ln_prior)
    }

    fn ln_evidence_of_single(
        &self,
        restored: &Restored<'_, 'a>,
        placement: Placement,
    ) -> Option<f64> {
        let walker = self.beginning.walker(Hypothesis {
            morphology: restored.morphology.clone(),
            lost_links: restored.lost_links,
            effects: vec![placement],
        });
        let Placement { effect, place } = placement;
        let record = self.beginning.observation.record;
        let starts = effect
            .starts(place, self.beginning.nominal, record)
            .into_iter();
        let points = starts.map(|values| walker.described(&[values]));
        restored.taken_for.ln_evidence_of_other(&walker, points)
    }

    /// Each damaged leg of these robots restored, without robots on which every effect is screened anyhow.
    fn restored_of<'b>(
        &self,
        begun: &'b [Base<'a>],
        screened: &[Screened<'a>],
    ) -> Vec<Restored<'b, 'a>> {
        let mut wanted: Vec<Restored<'b, 'a>> = Vec::new();
        let mut seen: Vec<Vec<usize>> = Vec::new();
        for taken_for in begun {
            let damaged = taken_for.morphology.damaged_legs();
            if seen.contains(&damaged) {
                continue;
            }
            for leg in damaged.iter().copied() {
                let morphology = with_leg_restored(&taken_for.morphology, leg - 1);
                let lost_links = match morphology.is_healthy() {
                    true => LostLinks::Absent,
                    false => taken_for.lost_links,
                };
                let is_screened = screened
                    .iter()
                    .any(|on| on.base.morphology == morphology && on.base.lost_links == lost_links);
                let is_known = wanted.iter().any(|one| {
                    one.leg == leg && one.morphology == morphology && one.lost_links == lost_links
                });
                if !is_screened && !is_known {
                    wanted.push(Restored {
                        taken_for,
                        ln_prior: (self.known.ln_morphology)(&morphology),
                        morphology,
                        lost_links,
                        leg,
                    });
                }
            }
            seen.push(damaged);
        }
        wanted
    }
}

/// The same robot with this leg, from 0, whole.
pub(super) fn with_leg_restored(robot: &Morphology, leg: usize) -> Morphology {
    robot.clone().with_remaining(leg, robot.links(leg))
}
