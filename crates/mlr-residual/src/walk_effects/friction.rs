use std::collections::BTreeMap;

use super::{Place, WalkEffect, effect::named};
use crate::{
    Parameter,
    walk::{WalkModel, WalkRecord},
};

/// The ground grips otherwise than usual.
#[derive(Debug)]
pub(super) struct Friction;

impl WalkEffect for Friction {
    fn kind(&self) -> &'static str {
        "friction"
    }

    fn trace(&self) -> &'static str {
        "the feet slip: the body turns by another angle, and jerks less or more"
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<Parameter> {
        let ratio = Parameter::new("ln_friction", 0.0);
        vec![ratio.step(0.08).bounds(-3.0, 1.0).neutral(0.0).usual(0.25)]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        [0.15, 0.3, 0.55, 1.4]
            .map(|share: f64| vec![share.ln()])
            .into()
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        model.simulation.contact.friction *= values[0].exp();
    }

    fn report(&self, _: Place, values: &[f64], model: &WalkModel) -> BTreeMap<String, f64> {
        named([("mu", model.simulation.contact.friction * values[0].exp())])
    }
}
