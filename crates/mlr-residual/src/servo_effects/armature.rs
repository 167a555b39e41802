use std::collections::BTreeMap;

use super::{EffectParameter, ServoEffect, effect::named};
use crate::servo::ServoModel;

/// The rotor turns with the joint, and much faster: it is as heavy as the square of the gears' ratio
/// makes it.
///
/// - `ln_share`: logarithm of its inertia over that of the arm. People read `armature_kg_m2`.
/// - Prior: median 0.2, a factor of 2.7 either way. Assumed.
#[derive(Debug)]
pub(super) struct Armature;

impl ServoEffect for Armature {
    fn kind(&self) -> &'static str {
        "armature"
    }

    fn signature(&self) -> &'static str {
        "oscillations and reversals come too early"
    }

    fn parameters(&self, _: &ServoModel) -> Vec<EffectParameter> {
        vec![EffectParameter::ln("ln_share", 0.2, 1.0)]
    }

    fn apply(&self, values: &[f64], model: &mut ServoModel) {
        model.bench.servo.drive.armature_kg_m2 = inertia_kg_m2(model) * values[0].exp();
    }

    fn report(&self, values: &[f64], described: &ServoModel) -> BTreeMap<String, f64> {
        named([("armature_kg_m2", inertia_kg_m2(described) * values[0].exp())])
    }
}

/// Inertia of the arm about the shaft.
fn inertia_kg_m2(model: &ServoModel) -> f64 {
    let arm = model.bench.arm;
    arm.mass_kg * arm.length_m * arm.length_m + arm.inertia_kg_m2
}
