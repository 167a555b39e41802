use std::collections::BTreeMap;

use mlr_model::{Fault, Morphology, Robot};

use super::{Place, WalkEffect, effect::named};
use crate::{
    Parameter,
    walk::{WalkModel, WalkRecord},
};

/// The servos of one leg have lost strength.
#[derive(Debug)]
pub(super) struct WeakLeg;

impl WalkEffect for WeakLeg {
    fn kind(&self) -> &'static str {
        "weak_leg"
    }

    fn trace(&self) -> &'static str {
        "the body sinks towards that leg while it stands"
    }

    fn places(&self, _: &Robot, morphology: &Morphology) -> Vec<Place> {
        Place::legs(morphology)
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<Parameter> {
        vec![
            Parameter::new("ln_gain", 0.0)
                .step(0.08)
                .bounds(-3.5, 0.0)
                .neutral(0.0)
                .usual(0.15),
        ]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        [0.2, 0.5].map(|gain: f64| vec![gain.ln()]).into()
    }

    fn apply(&self, place: Place, values: &[f64], model: &mut WalkModel) {
        let gain = values[0].exp();
        let leg = place.leg();
        model.simulation.faults.push(Fault::WeakLeg { leg, gain });
    }

    fn report(&self, place: Place, values: &[f64], _: &WalkModel) -> BTreeMap<String, f64> {
        named([("leg", place.leg() as f64), ("gain", values[0].exp())])
    }
}
