//! The robots that effects are added to.

use std::sync::Arc;

use mlr_model::Morphology;
use rayon::prelude::*;

use super::{Judged, Search, Suspect, base::Base, proposals::Screened, screening, sort_judged};

/// Robots without effects over the beginning of the walk.
pub(super) struct Bases<'a> {
    /// After a first step, the likeliest first.
    pub(super) begun: Vec<Base<'a>>,
    /// At their most probable walks, as far as they may still win.
    pub(super) settled: Vec<Arc<Base<'a>>>,
    /// What the identification took the robot for.
    identified: Option<Morphology>,
}

impl<'a> Search<'a, '_> {
    pub(super) fn bases(&self, suspects: &[Suspect]) -> Bases<'a> {
        let weight = |base: &Base<'a>| self.ln_weight_of(base);
        let begun = self.first_steps(suspects).into_iter();
        let mut ranked: Vec<(f64, Base<'a>)> = begun.map(|base| (weight(&base), base)).collect();
        ranked.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        let best = ranked.first().map_or(0.0, |(weight, _)| *weight);
        // A first step says little of robots that stand a long way from their description: the one
        // identified and one that lacks no link go on in any case.
        let identified = suspects.first().map(|suspect| &suspect.morphology);
        let goes_on =
            |base: &Base<'a>| base.morphology.is_healthy() || Some(&base.morphology) == identified;
        let mut others = self.effort.bases;
        let mut kept: Vec<&Base<'a>> = Vec::new();
        for (weight, base) in &ranked {
            if goes_on(base) {
                kept.push(base);
            } else if others > 0 && *weight > best - self.hopeless() {
                others -= 1;
                kept.push(base);
            }
        }
        let settled = kept.into_par_iter().filter_map(|base| self.settled(base));
        Bases {
            settled: settled.collect(),
            begun: ranked.into_iter().map(|(_, base)| base).collect(),
            identified: identified.cloned(),
        }
    }

    /// A robot at its most probable walk of the beginning.
    fn settled(&self, base: &Base<'a>) -> Option<Arc<Base<'a>>> {
        let settled = base
            .settled()?
            .scattered(self.beginning_of_means, self.generator)?;
        Some(Arc::new(settled))
    }

    /// Logarithm of the weight of a base without effects.
    pub(super) fn ln_weight_of(&self, base: &Base<'a>) -> f64 {
        base.ln_evidence() + self.ln_prior(base.ln_prior, &base.with(Vec::new()))
    }

    pub(super) fn without_effects(&self, bases: &[Arc<Base<'a>>]) -> Vec<Judged<'a>> {
        let mut judged: Vec<Judged<'a>> = bases
            .iter()
            .map(|base| {
                let walker = base.with(Vec::new());
                let fit = base.fit(&walker);
                self.judge(base, walker, fit)
            })
            .collect();
        sort_judged(&mut judged);
        judged
    }

    /// The starts of effects on the likeliest robots, of each set of damaged legs and state of the lost
    /// links one, as long as they may still win; and on the robot as identified in any case.
    pub(super) fn screened(&self, ranked: &[Judged<'a>], all: &Bases<'a>) -> Vec<Screened<'a>> {
        let mut bases: Vec<Arc<Base<'a>>> = Vec::new();
        for judged in ranked {
            let base = &judged.base;
            let alike = |other: &&Arc<Base<'a>>| {
                other.morphology.damaged_legs() == base.morphology.damaged_legs()
                    && other.lost_links == base.lost_links
            };
            if !bases.iter().any(|other| alike(&other)) && bases.len() < self.effort.screened {
                bases.push(Arc::clone(base));
            }
        }
        // Other robots may walk more like one with an effect than the same without it, above all where it is known
        // how the robot walks without.
        let is_identified = |base: &Base<'a>| Some(&base.morphology) == all.identified.as_ref();
        if !bases.iter().any(|base| is_identified(base)) {
            let mut each = ranked.iter().map(|judged| &judged.base);
            if let Some(base) = each.find(|base| is_identified(base)) {
                bases.insert(0, Arc::clone(base));
            }
        }
        let mut screened: Vec<Screened<'a>> = Vec::new();
        let mut best = f64::NEG_INFINITY;
        for base in bases {
            if is_identified(&base) || self.ln_weight_of(&base) >= best - self.hopeless() {
                screened.push(self.screened_on(base, &mut best));
            }
        }
        screened
    }

    /// The starts of effects on one robot; `best` is the logarithm of the weight of the most promising so far.
    fn screened_on(&self, base: Arc<Base<'a>>, best: &mut f64) -> Screened<'a> {
        let on = Screened {
            starts: screening::starts(&base, self.progress),
            base,
        };
        let weights = (0..on.starts.len())
            .into_par_iter()
            .map(|k| self.proposal(&on, 0, vec![k]).ln_weight);
        *best = best.max(weights.reduce(|| f64::NEG_INFINITY, f64::max));
        on
    }
}
