use std::collections::BTreeMap;

use mlr_model::{Fault, Morphology, Robot};

use super::{EffectParameter, Place, WalkEffect, effect::named};
use crate::{
    Prior,
    walk::{WalkModel, WalkRecord},
};

/// The servos of one leg have lost strength.
///
/// - `ln_gain`: logarithm of what is left of their stiffness and torque limit, as a share; never
///   positive. People read `gain`.
/// - Prior: -1.1 ± 0.7: a servo that overheats, or has lost teeth, keeps about a third of its
///   torque. Assumed, not measured.
/// - Bounds: -3.5 to 0, a thirtieth to the whole strength.
#[derive(Debug)]
pub(super) struct WeakLeg;

impl WalkEffect for WeakLeg {
    fn kind(&self) -> &'static str {
        "weak_leg"
    }

    fn signature(&self) -> &'static str {
        "the body sinks towards that leg while it stands"
    }

    fn places(&self, _: &Robot, morphology: &Morphology) -> Vec<Place> {
        Place::legs(morphology)
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<EffectParameter> {
        let prior = Prior::Normal {
            mean: -1.1,
            deviation: 0.7,
        };
        vec![
            EffectParameter::new("ln_gain", prior)
                .bounds(-3.5, 0.0)
                .neutral(0.0),
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
