use std::collections::BTreeMap;

use super::{EffectParameter, Place, WalkEffect, effect::named};
use crate::{
    Prior,
    walk::{Nuisance, WalkModel, WalkRecord},
};

/// The servos of all legs give way more or less than described.
///
/// - `ln_stiffness`: logarithm of their stiffness over the described one; negative is softer.
///   People read `stiffness`, in N m/rad.
/// - Prior: -0.5 ± 0.5: at the end of a battery's charge a servo has about 0.6 of its torque.
///   Assumed, not measured.
/// - Bounds: -2.5 to 1.5, a twelfth to 4.5 times the described stiffness.
#[derive(Debug)]
pub(super) struct ServoStiffness;

impl ServoStiffness {
    fn stiffness(values: &[f64], model: &WalkModel) -> f64 {
        model.servo.stiffness_nm_per_rad * values[0].exp()
    }
}

impl WalkEffect for ServoStiffness {
    fn kind(&self) -> &'static str {
        "servo_stiffness"
    }

    fn signature(&self) -> &'static str {
        "every swing of the body is larger or smaller, and later"
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<EffectParameter> {
        let prior = Prior::Normal {
            mean: -0.5,
            deviation: 0.5,
        };
        vec![
            EffectParameter::new("ln_stiffness", prior)
                .bounds(-2.5, 1.5)
                .neutral(0.0),
        ]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        [0.4, 0.65].map(|share: f64| vec![share.ln()]).into()
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        model.servo.stiffness_nm_per_rad = Self::stiffness(values, model);
    }

    fn replaces(&self, _: Place) -> Vec<Nuisance> {
        vec![Nuisance::Stiffness]
    }

    fn standing_for(&self, changes: &[f64]) -> Option<Vec<f64>> {
        Some(changes.to_vec())
    }

    fn report(&self, _: Place, values: &[f64], model: &WalkModel) -> BTreeMap<String, f64> {
        named([("stiffness", Self::stiffness(values, model))])
    }
}
