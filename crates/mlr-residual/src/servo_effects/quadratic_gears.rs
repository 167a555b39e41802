use std::collections::BTreeMap;

use super::{EffectParameter, ServoEffect, effect::named};
use crate::servo::ServoModel;

/// Gears that bend: dry friction in proportion to the square of the torque that they carry, of the motor
/// and of the load.
///
/// - `ln_share`: logarithm of the friction over the torque limit, where the torque in the gears is that
///   limit. People read `quadratic_gears_per_nm`.
/// - Prior: median 0.1, a factor of 2.7 either way. Assumed.
#[derive(Debug)]
pub(super) struct QuadraticGears;

impl ServoEffect for QuadraticGears {
    fn kind(&self) -> &'static str {
        "quadratic_gears"
    }

    fn signature(&self) -> &'static str {
        "the more the joint carries, the less of the motor's torque reaches it"
    }

    fn parameters(&self, _: &ServoModel) -> Vec<EffectParameter> {
        vec![EffectParameter::ln("ln_share", 0.1, 1.0)]
    }

    fn apply(&self, values: &[f64], model: &mut ServoModel) {
        model.bench.servo.drive.quadratic_gears_per_nm = per_nm(values, model);
    }

    fn report(&self, values: &[f64], described: &ServoModel) -> BTreeMap<String, f64> {
        named([("quadratic_gears_per_nm", per_nm(values, described))])
    }
}

fn per_nm(values: &[f64], model: &ServoModel) -> f64 {
    values[0].exp() / model.described_limit_nm()
}
