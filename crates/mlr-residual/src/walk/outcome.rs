//! Hypotheses with their probabilities, something unknown among them.

use mlr_model::LostLinks;
use nalgebra::DVector;

use super::{
    EffectPrior,
    evidence::Fit,
    hypothesis::Walker,
    search::{Judged, Searched},
};
use crate::Posterior;

/// Lost links that hang on: an effect by its name.
pub const LOCKED_LINKS: &str = "locked_links";

/// One hypothesis of the posterior.
#[derive(Debug, Clone)]
pub(super) struct Outcome<'a> {
    pub(super) walker: Walker<'a>,
    /// How its parameters are known.
    weighed: Weighed,
    /// Whether something that no effect of the library makes adds to it.
    pub(super) unknown: bool,
}

#[derive(Debug, Clone)]
enum Weighed {
    /// By a fit over the whole stretch.
    Fit(Box<Fit>),
    /// By a linear model, with its most probable coordinates.
    LinearModel(DVector<f64>),
}

impl<'a> Outcome<'a> {
    fn fitted(judged: Judged<'a>) -> Self {
        Self {
            walker: judged.walker,
            weighed: Weighed::Fit(Box::new(judged.fit)),
            unknown: false,
        }
    }

    /// Its most probable coordinates.
    pub(super) fn coordinates(&self) -> &DVector<f64> {
        match &self.weighed {
            Weighed::Fit(fit) => &fit.walked.z,
            Weighed::LinearModel(coordinates) => coordinates,
        }
    }

    /// Its fit, where it was worth one.
    pub(super) fn fit(&self) -> Option<&Fit> {
        match &self.weighed {
            Weighed::Fit(fit) => Some(fit),
            Weighed::LinearModel(_) => None,
        }
    }

    pub(super) fn is_locked(&self) -> bool {
        let hypothesis = &self.walker.hypothesis;
        hypothesis.lost_links == LostLinks::Locked && !hypothesis.morphology.is_healthy()
    }

    /// The kinds of its effects, in order of their names.
    pub(super) fn kinds(&self) -> Vec<&'static str> {
        let effects = self.walker.hypothesis.effects.iter();
        let mut kinds: Vec<&'static str> = effects.map(|placed| placed.effect.kind()).collect();
        if self.is_locked() {
            kinds.push(LOCKED_LINKS);
        }
        if self.unknown {
            kinds.push("unknown");
        }
        kinds.sort_unstable();
        kinds.dedup();
        kinds
    }
}

/// Of each hypothesis the likeliest fit, with and without something unknown; hypotheses that were
/// not fitted by what their linear models promise. `None` where nothing was fitted.
pub(super) fn posterior<'a>(
    prior: &EffectPrior,
    searched: Searched<'a>,
) -> Option<Posterior<Outcome<'a>>> {
    let Searched {
        mut fitted,
        unfitted,
    } = searched;
    fitted.sort_by(|a, b| b.ln_weight.total_cmp(&a.ln_weight));
    let ln_nothing_unknown = (1.0 - prior.unknown).ln();
    let mut outcomes: Vec<(Outcome<'a>, f64)> = Vec::new();
    let mut with_unknown: Vec<(Outcome<'a>, f64)> = Vec::new();
    let is_known = |outcomes: &[(Outcome<'a>, f64)], walker: &Walker<'a>| {
        let mut known = outcomes.iter();
        known.any(|(one, _)| one.walker.hypothesis.is_same(&walker.hypothesis))
    };
    for judged in fitted {
        if is_known(&outcomes, &judged.walker) {
            continue;
        }
        let ln_weight = judged.ln_weight;
        let by_unknown = judged.ln_without_and_with_unknown;
        let outcome = Outcome::fitted(judged);
        let ln_without = match by_unknown {
            None => ln_nothing_unknown,
            Some([ln_without, ln_with]) => {
                let unknown = Outcome {
                    unknown: true,
                    ..outcome.clone()
                };
                with_unknown.push((unknown, ln_weight + ln_with));
                ln_without
            }
        };
        outcomes.push((outcome, ln_weight + ln_without));
    }
    for one in unfitted {
        if !is_known(&outcomes, &one.walker) {
            let outcome = Outcome {
                walker: one.walker,
                weighed: Weighed::LinearModel(one.coordinates),
                unknown: false,
            };
            outcomes.push((outcome, one.ln_weight + ln_nothing_unknown));
        }
    }
    let posterior = Posterior::new(outcomes.into_iter().chain(with_unknown));
    let is_fitted = |(one, _): &(Outcome<'a>, f64)| one.fit().is_some();
    posterior
        .ranked()
        .iter()
        .any(is_fitted)
        .then_some(posterior)
}
