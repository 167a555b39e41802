use std::collections::BTreeMap;

use super::{EffectParameter, ServoEffect, effect::named};
use crate::servo::ServoModel;

/// The controller ignores errors that are smaller than a band.
///
/// - `ln_angle`: logarithm of the largest error that is ignored, in rad. People read `angle_rad`.
/// - Prior: median 0.005, a factor of 2.7 either way: a few steps of the encoder. Assumed.
#[derive(Debug)]
pub(super) struct DeadBand;

impl ServoEffect for DeadBand {
    fn kind(&self) -> &'static str {
        "dead_band"
    }

    fn signature(&self) -> &'static str {
        "small errors are never corrected"
    }

    fn parameters(&self, _: &ServoModel) -> Vec<EffectParameter> {
        vec![EffectParameter::ln("ln_angle", 0.005, 1.0)]
    }

    fn apply(&self, values: &[f64], model: &mut ServoModel) {
        model.bench.servo.drive.dead_band_rad = values[0].exp().min(1.0);
    }

    fn report(&self, values: &[f64], _: &ServoModel) -> BTreeMap<String, f64> {
        named([("angle_rad", values[0].exp())])
    }
}
