use std::collections::BTreeMap;

use super::{EffectParameter, ServoEffect, effect::named};
use crate::servo::ServoModel;

/// Grease: friction in proportion to the speed, with and without current.
///
/// - `ln_share`: logarithm of the friction at 1 rad/s over the torque limit. People read
///   `viscous_nm_s_per_rad`.
/// - Prior: median 0.01, a factor of 2.7 either way. Assumed.
#[derive(Debug)]
pub(super) struct ViscousFriction;

impl ServoEffect for ViscousFriction {
    fn kind(&self) -> &'static str {
        "viscous_friction"
    }

    fn signature(&self) -> &'static str {
        "swings die away too slowly without current"
    }

    fn parameters(&self, _: &ServoModel) -> Vec<EffectParameter> {
        vec![EffectParameter::ln("ln_share", 0.01, 1.0)]
    }

    fn apply(&self, values: &[f64], model: &mut ServoModel) {
        model.bench.servo.drive.viscous_nm_s_per_rad = viscous(values, model);
    }

    fn report(&self, values: &[f64], described: &ServoModel) -> BTreeMap<String, f64> {
        named([("viscous_nm_s_per_rad", viscous(values, described))])
    }
}

fn viscous(values: &[f64], model: &ServoModel) -> f64 {
    model.described_limit_nm() * values[0].exp()
}
