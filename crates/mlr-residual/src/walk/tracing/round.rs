//! One round of tracing: every effect of the library is tried on top of those found.

use std::{collections::BTreeMap, sync::Arc};

use mlr_filter::OrientationSeries;
use rayon::prelude::*;

use super::{Suspect, state::State};
use crate::walk::{Comparison, Effort, Placed, Prediction, Trial, WalkRecord, Walker};
use crate::{
    Progress,
    walk_effects::{LIBRARY, Place, WalkEffect},
};

/// What all tries of a round have in common.
pub(super) struct Round<'r, 'a> {
    /// What effects compete with.
    pub(super) held: &'r Arc<State<'a>>,
    /// What the first looks cost with no effect more: for those for which the body has to walk,
    /// and those of the sensor.
    costs: [f64; 2],
    /// For first looks.
    brief: &'a WalkRecord,
    progress: &'r dyn Progress,
}

impl<'r, 'a> Round<'r, 'a> {
    /// `None` when the robot held does not walk.
    pub(super) fn new(
        held: &'r Arc<State<'a>>,
        brief: &'a WalkRecord,
        progress: &'r dyn Progress,
    ) -> Option<Self> {
        let footing = Footing::new(Arc::clone(held));
        let walked = footing.walked(brief)?;
        let costs = [&walked.briefly, &held.comparison]
            .map(|comparison| comparison.settle(&walked.predicted, &[]).cost);
        Some(Self {
            held,
            costs,
            brief,
            progress,
        })
    }

    /// Looks at every effect on each of these robots from all its starts, and fits those that
    /// look best: their cost, and `more` that a robot must gain with an effect on a leg, from 1
    /// (0: on none), comes near that of the robot held. Returns what is said of one trial per
    /// robot, kind and place, the best start of each.
    pub(super) fn try_on<J: Send>(
        &self,
        footings: &[Footing<'a>],
        screening: Screening,
        more: impl Fn(&Suspect, usize) -> f64,
        judge: impl Fn(&Footing<'a>, Trial) -> J + Sync,
    ) -> Vec<J> {
        let [of_body, of_sensing] = self.costs;
        let walked: Vec<Walked<'_, 'a>> = footings
            .par_iter()
            .filter_map(|footing| footing.walked(self.brief))
            .collect();
        let starts: Vec<(&Walked<'_, 'a>, Vec<Placed>)> = walked
            .iter()
            .flat_map(|walked| {
                let starts = walked.footing.starts().into_iter();
                starts.map(move |effects| (walked, effects))
            })
            .collect();
        self.progress.expect_more(starts.len());
        let glances = starts
            .into_par_iter()
            .filter_map(|(walked, effects)| {
                let glance = walked.glance(effects);
                self.progress.advance();
                let mut glance = glance?;
                glance.cost -= match glance.last().effect.is_of_sensing() {
                    true => of_sensing,
                    false => of_body,
                };
                Some(glance)
            })
            .collect();
        let chosen = most_promising(glances, screening, more);
        self.progress.expect_more(chosen.len());
        chosen
            .into_par_iter()
            .filter_map(|glance| {
                let trial = glance.walked.fit(glance.effects);
                self.progress.advance();
                Some(judge(glance.walked.footing, trial?))
            })
            .collect()
    }
}

/// A robot that effects are tried on.
pub(super) struct Footing<'a> {
    /// Its model, and the effects found.
    pub(super) base: Arc<State<'a>>,
    /// What walks with this model.
    pub(super) suspect: Suspect,
    /// Which effects are tried.
    pub(super) scope: Scope,
    /// What has been tried on it.
    pub(super) tried: Vec<Placed>,
}

/// Which effects are tried on a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scope {
    /// All of the library.
    All,
    /// Those of a leg, from 1.
    Leg(usize),
    /// Those that the rates of the standing robot show.
    AtRest,
}

impl Scope {
    fn contains(self, effect: &dyn WalkEffect, place: Place) -> bool {
        match self {
            Self::All => true,
            Self::Leg(leg) => place.leg() == leg,
            Self::AtRest => effect.shows_at_rest(),
        }
    }
}

/// A footing, and how it walks with the effects found.
struct Walked<'f, 'a> {
    footing: &'f Footing<'a>,
    body: OrientationSeries,
    predicted: Prediction,
    /// For first looks at effects for which the body has to walk.
    briefly: Comparison<'a>,
}

/// A first look at an effect on top of those found.
struct Glance<'f, 'a> {
    walked: &'f Walked<'f, 'a>,
    effects: Vec<Placed>,
    /// Less that of the robot held.
    cost: f64,
}

/// What an effect that nobody could overlook gains on either stretch: rates at rest show a bias
/// that clearly.
pub(super) const OBVIOUS_GAIN: f64 = 100.0;

/// Which first looks are followed by a fit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Screening {
    /// Fits of one kind, each at another place or on another robot.
    fits_per_kind: usize,
    /// How much worse than nothing, in the units of cost, the best first look of a kind may
    /// be, and others.
    slack: [f64; 2],
}

impl Screening {
    /// Of all effects at all places.
    pub(super) const BROAD: Self = Self {
        fits_per_kind: 2,
        slack: [20.0, 0.0],
    };
    /// Of effects on legs as if they were whole.
    pub(super) const RESTORED: Self = Self {
        fits_per_kind: 4,
        slack: [20.0, 0.0],
    };
    /// Of effects on robots that are not the one held: with the effect one must look nearly as
    /// good at once.
    pub(super) const BESIDE: Self = Self {
        fits_per_kind: 4,
        slack: [5.0, 0.0],
    };
    /// Of effects that nobody could overlook.
    pub(super) const OBVIOUS: Self = Self {
        fits_per_kind: 1,
        slack: [-OBVIOUS_GAIN; 2],
    };
    /// Of the effects on one leg that is known to be at fault.
    pub(super) const ONE_LEG: Self = Self {
        fits_per_kind: 3,
        slack: [f64::INFINITY; 2],
    };
}

/// The best start at each place, at the best places of each kind.
fn most_promising<'w, 'a>(
    mut glances: Vec<Glance<'w, 'a>>,
    screening: Screening,
    more: impl Fn(&Suspect, usize) -> f64,
) -> Vec<Glance<'w, 'a>> {
    let rank = |glance: &Glance<'_, '_>| {
        let suspect = &glance.walked.footing.suspect;
        glance.cost + more(suspect, glance.last().place.leg())
    };
    glances.sort_by(|a, b| rank(a).total_cmp(&rank(b)));
    let mut fits: BTreeMap<&'static str, usize> = BTreeMap::new();
    let mut chosen: Vec<Glance<'w, 'a>> = Vec::new();
    for glance in glances {
        let known = fits.entry(glance.last().effect.kind()).or_default();
        let [best, others] = screening.slack;
        let slack = if *known == 0 { best } else { others };
        let is_new =
            *known < screening.fits_per_kind && !chosen.iter().any(|other| other.is_alike(&glance));
        if is_new && glance.cost < slack {
            *known += 1;
            chosen.push(glance);
        }
    }
    chosen
}

impl<'a> Footing<'a> {
    /// Of all effects.
    pub(super) fn new(base: Arc<State<'a>>) -> Self {
        Self {
            suspect: base.suspect(),
            base,
            scope: Scope::All,
            tried: Vec::new(),
        }
    }

    /// `None` when it does not walk.
    fn walked(&self, brief: &'a WalkRecord) -> Option<Walked<'_, 'a>> {
        let found = &self.base.trial.effects;
        let comparison = &self.base.comparison;
        let (body, predicted) = self.walker(None).walked(comparison, found)?;
        Some(Walked {
            footing: self,
            body,
            predicted,
            briefly: comparison.with_record(brief),
        })
    }

    /// Every start of every effect that is to be tried, on top of those found.
    fn starts(&self) -> Vec<Vec<Placed>> {
        let found = &self.base.trial.effects;
        let record = self.base.comparison.record;
        let model = self.walker(None).with(found);
        let mut starts = Vec::new();
        for effect in kinds_for(&self.base.comparison) {
            for place in effect.places(&model.robot, &self.suspect.morphology) {
                if !self.scope.contains(effect, place) {
                    continue;
                }
                for values in effect.starts(place, &model, record) {
                    let start = Placed {
                        effect,
                        place,
                        values,
                    };
                    let mut known = found.iter().chain(&self.tried);
                    if !known.any(|placed| placed.is_same(&start)) {
                        let mut effects = found.clone();
                        effects.push(start);
                        starts.push(effects);
                    }
                }
            }
        }
        starts
    }

    fn walker<'f>(&'f self, body: Option<&'f OrientationSeries>) -> Walker<'f> {
        Walker {
            model: &self.base.calibration_model,
            morphology: &self.suspect.morphology,
            body,
        }
    }
}

impl<'a> Walked<'_, 'a> {
    /// For an effect of the sensor only, nothing has to walk.
    fn glance(&self, effects: Vec<Placed>) -> Option<Glance<'_, 'a>> {
        let comparison = match effects.last()?.effect.is_of_sensing() {
            true => &self.footing.base.comparison,
            false => &self.briefly,
        };
        let walker = self.footing.walker(Some(&self.body));
        let (cost, effects) = walker.glance(comparison, &self.predicted, effects)?;
        Some(Glance {
            walked: self,
            effects,
            cost,
        })
    }

    fn fit(&self, effects: Vec<Placed>) -> Option<Trial> {
        let base = &self.footing.base;
        let walker = self.footing.walker(Some(&self.body));
        walker.fit(
            &base.comparison,
            effects,
            base.trial.effects.len(),
            Effort::Polls,
        )
    }
}

impl Glance<'_, '_> {
    /// The effect that is looked at.
    fn last(&self) -> &Placed {
        self.effects
            .last()
            .expect("a start adds an effect to those found")
    }

    /// Whether the same effect is at the same place of the same robot.
    fn is_alike(&self, other: &Self) -> bool {
        std::ptr::eq(self.walked, other.walked) && self.last().is_same(other.last())
    }
}

/// The kinds that a record can tell from nothing.
fn kinds_for(comparison: &Comparison<'_>) -> Vec<&'static dyn WalkEffect> {
    let told = comparison.record.start_is_told();
    let kinds = LIBRARY.iter().copied();
    kinds
        .filter(|effect| told || !effect.is_a_delay())
        .collect()
}
