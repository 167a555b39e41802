//! One round of tracing: every effect of the library is tried on top of those found.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::walk::{Comparison, Placed, Trial, Walker};
use crate::{
    Progress,
    walk_effects::{LIBRARY, Place, WalkEffect},
};

/// Which first looks are followed by a fit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Screening {
    /// Places of one kind that are fitted.
    places_per_kind: usize,
    /// How much worse than nothing, in the units of cost, a first look may be at the best
    /// place of a kind, and at others.
    slack: [f64; 2],
}

impl Screening {
    /// Of all effects at all places.
    pub(crate) const BROAD: Self = Self {
        places_per_kind: 2,
        slack: [20.0, 0.0],
    };
    /// Of effects on a robot that is not the one held: with the effect it must look nearly as
    /// good at once.
    pub(crate) const BESIDE: Self = Self {
        places_per_kind: 2,
        slack: [5.0, 0.0],
    };
    /// Of the effects on one leg that is known to be at fault.
    pub(crate) const ONE_LEG: Self = Self {
        places_per_kind: 3,
        slack: [f64::INFINITY; 2],
    };
}

/// Fits every effect from its starts on top of `found`, each where it looks best at first.
/// `so_far` is the cost that it competes with. Returns one trial per kind and place, the
/// best start of each.
pub(crate) fn try_all(
    walker: &Walker<'_>,
    comparison: &Comparison<'_>,
    found: &[Placed],
    starts: Vec<Vec<Placed>>,
    screening: Screening,
    so_far: f64,
    progress: &dyn Progress,
) -> Vec<Trial> {
    let Some((body, without)) = walker.walked(comparison, found) else {
        return Vec::new();
    };
    let walker = Walker {
        body: Some(&body),
        ..*walker
    };
    progress.expect_more(starts.len());
    let glances: Vec<(f64, Vec<Placed>)> = starts
        .into_par_iter()
        .filter_map(|effects| {
            let glance = walker.glance(comparison, &without, effects);
            progress.advance();
            glance
        })
        .collect();
    let chosen = most_promising(glances, screening, so_far);
    progress.expect_more(chosen.len());
    chosen
        .into_par_iter()
        .filter_map(|effects| {
            let trial = walker.fit(comparison, effects, found.len());
            progress.advance();
            trial
        })
        .collect()
}

/// Every start of every effect that is not there yet, on top of those found.
pub(crate) fn starts(
    walker: &Walker<'_>,
    comparison: &Comparison<'_>,
    found: &[Placed],
    kinds: &[&'static dyn WalkEffect],
) -> Vec<Vec<Placed>> {
    let model = walker.with(found);
    let mut starts = Vec::new();
    for effect in kinds.iter().copied() {
        for place in effect.places(&model.robot, walker.morphology) {
            for values in effect.starts(place, &model, comparison.record) {
                let start = Placed {
                    effect,
                    place,
                    values,
                };
                if !found.iter().any(|placed| placed.is_same(&start)) {
                    let mut effects = found.to_vec();
                    effects.push(start);
                    starts.push(effects);
                }
            }
        }
    }
    starts
}

/// The best start at each place, at the best places of each kind.
fn most_promising(
    mut glances: Vec<(f64, Vec<Placed>)>,
    screening: Screening,
    so_far: f64,
) -> Vec<Vec<Placed>> {
    glances.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let mut places: BTreeMap<&'static str, Vec<Place>> = BTreeMap::new();
    let mut chosen = Vec::new();
    for (cost, effects) in glances {
        let Some(last) = effects.last() else { continue };
        let known = places.entry(last.effect.kind()).or_default();
        let [best, others] = screening.slack;
        let slack = if known.is_empty() { best } else { others };
        let is_new = known.len() < screening.places_per_kind && !known.contains(&last.place);
        if is_new && cost < so_far + slack {
            known.push(last.place);
            chosen.push(effects);
        }
    }
    chosen
}

/// The kinds that a record can tell from nothing.
pub(crate) fn kinds_for(comparison: &Comparison<'_>) -> Vec<&'static dyn WalkEffect> {
    let told = comparison.record.start_is_told();
    let kinds = LIBRARY.iter().copied();
    kinds
        .filter(|effect| told || !effect.is_a_delay())
        .collect()
}
