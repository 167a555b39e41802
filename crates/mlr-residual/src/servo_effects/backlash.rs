use std::collections::BTreeMap;

use super::{EffectParameter, ServoEffect, effect::named};
use crate::servo::ServoModel;

/// Play of the gears: the joint is free over an angle about where the motor holds it.
///
/// - `ln_angle`: logarithm of the angle in rad. People read `angle_rad`.
/// - Prior: median 0.01, a factor of 2.7 either way: half a degree is usual of small servos.
#[derive(Debug)]
pub(super) struct Backlash;

impl ServoEffect for Backlash {
    fn kind(&self) -> &'static str {
        "backlash"
    }

    fn signature(&self) -> &'static str {
        "the joint hangs to the side of its load"
    }

    fn parameters(&self, _: &ServoModel) -> Vec<EffectParameter> {
        vec![EffectParameter::ln("ln_angle", 0.01, 1.0)]
    }

    fn apply(&self, values: &[f64], model: &mut ServoModel) {
        model.bench.servo.drive.backlash_rad = values[0].exp().min(1.0);
    }

    fn report(&self, values: &[f64], _: &ServoModel) -> BTreeMap<String, f64> {
        named([("angle_rad", values[0].exp())])
    }
}
