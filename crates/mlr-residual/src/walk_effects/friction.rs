use std::collections::BTreeMap;

use super::{EffectParameter, Place, WalkEffect, effect::named};
use crate::{
    Prior,
    walk::{Nuisance, WalkModel, WalkRecord},
};

/// The ground grips better or worse than described.
///
/// - `ln_friction`: logarithm of the friction coefficient over the described one; negative slips.
///   People read `mu`, the coefficient itself.
/// - Prior: -0.5 ± 0.6: rubber has 0.6 to 0.9 on dry floors, which is what descriptions assume;
///   smooth, dusty or wet floors have a half or a quarter of it. Assumed, not measured.
/// - Bounds: -3 to 1, a twentieth to nearly thrice the described coefficient.
#[derive(Debug)]
pub(super) struct Friction;

impl WalkEffect for Friction {
    fn kind(&self) -> &'static str {
        "friction"
    }

    fn signature(&self) -> &'static str {
        "the feet slip: the body turns by another angle, and jerks less or more"
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<EffectParameter> {
        let prior = Prior::Normal {
            mean: -0.5,
            deviation: 0.6,
        };
        vec![
            EffectParameter::new("ln_friction", prior)
                .bounds(-3.0, 1.0)
                .neutral(0.0),
        ]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        [0.3, 0.6].map(|share: f64| vec![share.ln()]).into()
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        model.simulation.contact.friction *= values[0].exp();
    }

    fn replaces(&self, _: Place) -> Vec<Nuisance> {
        vec![Nuisance::Friction]
    }

    fn standing_for(&self, changes: &[f64]) -> Option<Vec<f64>> {
        Some(changes.to_vec())
    }

    fn report(&self, _: Place, values: &[f64], model: &WalkModel) -> BTreeMap<String, f64> {
        named([("mu", model.simulation.contact.friction * values[0].exp())])
    }
}
