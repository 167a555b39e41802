use std::collections::BTreeMap;

use super::{EffectParameter, ServoEffect, effect::named};
use crate::servo::ServoModel;

/// Friction under load that is larger at rest than in motion.
///
/// - `ln_coefficient`: logarithm of what is more at rest, over the torque. People read `coefficient`.
/// - Prior: median 0.1, a factor of 2.7 either way. Assumed.
#[derive(Debug)]
pub(super) struct StribeckLoad;

impl ServoEffect for StribeckLoad {
    fn kind(&self) -> &'static str {
        "stribeck_load"
    }

    fn signature(&self) -> &'static str {
        "under load the joint sticks, then jumps"
    }

    fn parameters(&self, _: &ServoModel) -> Vec<EffectParameter> {
        vec![EffectParameter::ln("ln_coefficient", 0.1, 1.0)]
    }

    fn apply(&self, values: &[f64], model: &mut ServoModel) {
        model.bench.servo.drive.stribeck_load = values[0].exp();
    }

    fn report(&self, values: &[f64], _: &ServoModel) -> BTreeMap<String, f64> {
        named([("coefficient", values[0].exp())])
    }
}
