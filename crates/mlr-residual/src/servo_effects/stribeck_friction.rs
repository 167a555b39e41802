use std::collections::BTreeMap;

use super::{EffectParameter, ServoEffect, effect::named};
use crate::servo::ServoModel;

/// Dry friction that is larger at rest than in motion (Stribeck): the joint sticks and slips.
///
/// - `ln_share`: logarithm of what is more at rest, over the torque limit; `ln_speed`: that of the speed in
///   rad/s over which it vanishes. People read `stribeck_nm` and `stribeck_speed_rad_per_s`.
/// - Prior: median 0.02, a factor of 2.7 either way; median 0.5 rad/s, a factor of 2.2. Assumed.
#[derive(Debug)]
pub(super) struct StribeckFriction;

impl ServoEffect for StribeckFriction {
    fn kind(&self) -> &'static str {
        "stribeck_friction"
    }

    fn signature(&self) -> &'static str {
        "the joint sticks, then jumps"
    }

    fn parameters(&self, _: &ServoModel) -> Vec<EffectParameter> {
        vec![
            EffectParameter::ln("ln_share", 0.02, 1.0),
            EffectParameter::ln("ln_speed", 0.5, 0.8),
        ]
    }

    fn apply(&self, values: &[f64], model: &mut ServoModel) {
        model.bench.servo.drive.stribeck_nm = stribeck_nm(values, model);
        model.bench.servo.drive.stribeck_speed_rad_per_s = values[1].exp();
    }

    fn report(&self, values: &[f64], described: &ServoModel) -> BTreeMap<String, f64> {
        named([
            ("stribeck_nm", stribeck_nm(values, described)),
            ("stribeck_speed_rad_per_s", values[1].exp()),
        ])
    }
}

fn stribeck_nm(values: &[f64], model: &ServoModel) -> f64 {
    model.described_limit_nm() * values[0].exp()
}
