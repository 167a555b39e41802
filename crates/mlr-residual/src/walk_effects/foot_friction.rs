use std::collections::BTreeMap;

use mlr_model::{Fault, Morphology, Robot};

use super::{EffectParameter, Place, WalkEffect, effect::named};
use crate::{
    Prior,
    walk::{WalkModel, WalkRecord},
};

/// One foot grips better or worse than the others.
///
/// - `ln_friction`: logarithm of this foot's friction coefficient over that of the others;
///   negative slips. People read `mu`, the coefficient itself.
/// - Prior: -1.1 ± 0.7: a foot that has lost its rubber, or is dirty, grips about a third as well
///   (bare plastic 0.2 to 0.3, rubber 0.6 to 0.9 on dry floors). Assumed, not measured.
/// - Bounds: -3.5 to 1, a thirtieth to nearly thrice the others' coefficient.
#[derive(Debug)]
pub(super) struct FootFriction;

impl FootFriction {
    fn mu(values: &[f64], model: &WalkModel) -> f64 {
        model.simulation.contact.friction * values[0].exp()
    }
}

impl WalkEffect for FootFriction {
    fn kind(&self) -> &'static str {
        "foot_friction"
    }

    fn signature(&self) -> &'static str {
        "the body turns while that foot stands"
    }

    fn places(&self, _: &Robot, morphology: &Morphology) -> Vec<Place> {
        Place::feet(morphology)
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<EffectParameter> {
        let prior = Prior::Normal {
            mean: -1.1,
            deviation: 0.7,
        };
        vec![
            EffectParameter::new("ln_friction", prior)
                .bounds(-3.5, 1.0)
                .neutral(0.0),
        ]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        [0.15, 0.5].map(|share: f64| vec![share.ln()]).into()
    }

    fn apply(&self, place: Place, values: &[f64], model: &mut WalkModel) {
        let mu = Self::mu(values, model);
        let leg = place.leg();
        model
            .simulation
            .faults
            .push(Fault::FootFriction { leg, mu });
    }

    fn report(&self, place: Place, values: &[f64], model: &WalkModel) -> BTreeMap<String, f64> {
        named([("leg", place.leg() as f64), ("mu", Self::mu(values, model))])
    }
}
