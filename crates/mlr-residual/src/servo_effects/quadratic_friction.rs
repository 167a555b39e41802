use std::collections::BTreeMap;

use super::{EffectParameter, ServoEffect, effect::named};
use crate::servo::ServoModel;

/// Gears and bearings that bend under load: dry friction in proportion to the square of the torque.
///
/// - `ln_share`: logarithm of the friction at the torque limit over that limit. People read
///   `quadratic_load_per_nm`.
/// - Prior: median 0.3, a factor of 2.7 either way: gears of plastic or brass stand still near their
///   limit. Assumed.
#[derive(Debug)]
pub(super) struct QuadraticFriction;

impl ServoEffect for QuadraticFriction {
    fn kind(&self) -> &'static str {
        "quadratic_friction"
    }

    fn signature(&self) -> &'static str {
        "near the torque limit the joint nearly stands still"
    }

    fn parameters(&self, _: &ServoModel) -> Vec<EffectParameter> {
        vec![EffectParameter::ln("ln_share", 0.3, 1.0)]
    }

    fn start_coordinates(&self) -> &'static [f64] {
        &[1.0, 0.0, -1.0]
    }

    fn apply(&self, values: &[f64], model: &mut ServoModel) {
        model.bench.servo.drive.quadratic_load_per_nm = per_nm(values, model);
    }

    fn report(&self, values: &[f64], described: &ServoModel) -> BTreeMap<String, f64> {
        named([("quadratic_load_per_nm", per_nm(values, described))])
    }
}

fn per_nm(values: &[f64], model: &ServoModel) -> f64 {
    values[0].exp() / model.described_limit_nm()
}
