use std::collections::BTreeMap;

use super::{EffectParameter, ServoEffect, effect::named};
use crate::servo::ServoModel;

/// The controller makes more or less torque of an error than described, below its limit.
///
/// - `ln_gain`: logarithm of the gain over the described one. People read `gain`.
/// - Prior: 0 ± 0.7: a unit or a power of two that data sheet and firmware do not agree on. Assumed.
#[derive(Debug)]
pub(super) struct PositionGain;

impl ServoEffect for PositionGain {
    fn kind(&self) -> &'static str {
        "position_gain"
    }

    fn signature(&self) -> &'static str {
        "the servo stops short of its goal by too much or too little"
    }

    fn parameters(&self, _: &ServoModel) -> Vec<EffectParameter> {
        vec![EffectParameter::ln("ln_gain", 1.0, 0.7)]
    }

    fn start_coordinates(&self) -> &'static [f64] {
        &[-1.0, 1.0]
    }

    fn apply(&self, values: &[f64], model: &mut ServoModel) {
        model.bench.servo.stiffness_nm_per_rad *= values[0].exp();
    }

    fn report(&self, values: &[f64], _: &ServoModel) -> BTreeMap<String, f64> {
        named([("gain", values[0].exp())])
    }
}
