use std::collections::BTreeMap;

use super::{EffectParameter, ServoEffect, effect::named};
use crate::servo::ServoModel;

/// The motor's torque grows less than its current: of small currents it makes more than in proportion to
/// what it makes at its limit.
///
/// - `ln_saturation`: logarithm of what the torque per current is larger by at small currents, over that at
///   the torque limit. People read `saturation`.
/// - Prior: median 0.3, a factor of 2.7 either way. Assumed.
#[derive(Debug)]
pub(super) struct TorqueSaturation;

impl ServoEffect for TorqueSaturation {
    fn kind(&self) -> &'static str {
        "torque_saturation"
    }

    fn signature(&self) -> &'static str {
        "small errors move the joint too far, large ones too little"
    }

    fn parameters(&self, _: &ServoModel) -> Vec<EffectParameter> {
        vec![EffectParameter::ln("ln_saturation", 0.3, 1.0)]
    }

    fn start_coordinates(&self) -> &'static [f64] {
        &[1.0, 0.0, -1.0]
    }

    /// The largest torque stays the same, and the effort that an error is answered with.
    fn apply(&self, values: &[f64], model: &mut ServoModel) {
        let saturation = values[0].exp().min(100.0);
        model.bench.servo.drive.torque_saturation = saturation;
        model.bench.servo.stiffness_nm_per_rad *= 1.0 + saturation;
    }

    fn report(&self, values: &[f64], _: &ServoModel) -> BTreeMap<String, f64> {
        named([("saturation", values[0].exp().min(100.0))])
    }
}
