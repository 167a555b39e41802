use std::collections::BTreeMap;

use super::{EffectParameter, ServoEffect, effect::named};
use crate::servo::ServoModel;

/// Gears that are pressed together: dry friction in proportion to the torque they carry.
///
/// - `ln_coefficient`: logarithm of friction over torque. People read `coefficient`.
/// - Prior: median 0.15, a factor of 2 either way: four stages of spur gears that lose a few per cent each,
///   of both the torque of the motor and that of the load.
#[derive(Debug)]
pub(super) struct LoadFriction;

impl ServoEffect for LoadFriction {
    fn kind(&self) -> &'static str {
        "load_friction"
    }

    fn signature(&self) -> &'static str {
        "under load the joint stops early on its way up and late on its way down"
    }

    fn parameters(&self, _: &ServoModel) -> Vec<EffectParameter> {
        vec![EffectParameter::ln("ln_coefficient", 0.15, 0.7)]
    }

    fn apply(&self, values: &[f64], model: &mut ServoModel) {
        model.bench.servo.drive.load_friction = values[0].exp();
    }

    fn report(&self, values: &[f64], _: &ServoModel) -> BTreeMap<String, f64> {
        named([("coefficient", values[0].exp())])
    }
}
