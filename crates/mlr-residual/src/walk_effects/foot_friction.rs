use std::collections::BTreeMap;

use mlr_model::{Fault, Morphology, Robot};

use super::{Place, WalkEffect, effect::named};
use crate::{
    Parameter,
    walk::{WalkModel, WalkRecord},
};

/// One foot grips otherwise than the others.
#[derive(Debug)]
pub(super) struct FootFriction;

/// How much less a foot usually grips, where it does: a third as well, worn or dirty.
/// Logarithm of the ratio.
const USUAL_WHERE_OFF: f64 = 1.1;

impl FootFriction {
    fn mu(values: &[f64], model: &WalkModel) -> f64 {
        model.simulation.contact.friction * values[0].exp()
    }
}

impl WalkEffect for FootFriction {
    fn kind(&self) -> &'static str {
        "foot_friction"
    }

    fn trace(&self) -> &'static str {
        "the body turns while that foot stands"
    }

    fn places(&self, _: &Robot, morphology: &Morphology) -> Vec<Place> {
        Place::feet(morphology)
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<Parameter> {
        let ratio = Parameter::new("ln_friction", 0.0);
        vec![ratio.step(0.15).bounds(-3.5, 1.0).neutral(0.0).usual(0.5)]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        [0.12, 0.25, 0.5].map(|share: f64| vec![share.ln()]).into()
    }

    fn apply(&self, place: Place, values: &[f64], model: &mut WalkModel) {
        let mu = Self::mu(values, model);
        let leg = place.leg();
        model
            .simulation
            .faults
            .push(Fault::FootFriction { leg, mu });
    }

    fn rarity(&self, values: &[f64]) -> f64 {
        (values[0] / USUAL_WHERE_OFF).powi(2)
    }

    fn report(&self, place: Place, values: &[f64], model: &WalkModel) -> BTreeMap<String, f64> {
        named([("leg", place.leg() as f64), ("mu", Self::mu(values, model))])
    }
}
