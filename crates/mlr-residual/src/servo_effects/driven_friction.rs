use std::collections::BTreeMap;

use super::{EffectParameter, ServoEffect, effect::named};
use crate::servo::ServoModel;

/// Gears lose more, or less, of the torque of the load than of that of the motor.
///
/// - `ln_ratio`: logarithm of the friction per torque of the load over that of the motor. People read
///   `driven_ratio`.
/// - Prior: 0 ± 1. Assumed.
#[derive(Debug)]
pub(super) struct DrivenFriction;

impl ServoEffect for DrivenFriction {
    fn kind(&self) -> &'static str {
        "driven_friction"
    }

    fn signature(&self) -> &'static str {
        "loads are held better, or worse, than they are lifted"
    }

    fn parameters(&self, _: &ServoModel) -> Vec<EffectParameter> {
        vec![EffectParameter::ln("ln_ratio", 1.0, 1.0)]
    }

    fn start_coordinates(&self) -> &'static [f64] {
        &[-2.0, -1.0, 1.0]
    }

    fn apply(&self, values: &[f64], model: &mut ServoModel) {
        model.bench.servo.drive.driven_ratio = values[0].exp();
    }

    fn report(&self, values: &[f64], _: &ServoModel) -> BTreeMap<String, f64> {
        named([("driven_ratio", values[0].exp())])
    }

    fn builds_on(&self) -> Option<&'static str> {
        Some("load_friction")
    }
}
