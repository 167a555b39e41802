use std::collections::BTreeMap;

use super::{EffectParameter, ServoEffect, effect::named};
use crate::servo::ServoModel;

/// The motor pulls more or less than its data sheet says, at every error.
///
/// - `ln_torque`: logarithm of the torque over the described one. People read `torque_limit_nm`.
/// - Prior: 0 ± 0.4: data sheets give the stall torque at one supply, of a motor that is cold.
#[derive(Debug)]
pub(super) struct MotorTorque;

impl ServoEffect for MotorTorque {
    fn kind(&self) -> &'static str {
        "motor_torque"
    }

    fn signature(&self) -> &'static str {
        "every slow motion is too large or too small, at the limit as well"
    }

    fn parameters(&self, _: &ServoModel) -> Vec<EffectParameter> {
        vec![EffectParameter::ln("ln_torque", 1.0, 0.4)]
    }

    fn start_coordinates(&self) -> &'static [f64] {
        &[-1.0, 1.0]
    }

    fn apply(&self, values: &[f64], model: &mut ServoModel) {
        let torque = values[0].exp();
        model.bench.servo.torque_limit_nm *= torque;
        model.bench.servo.stiffness_nm_per_rad *= torque;
    }

    fn report(&self, values: &[f64], described: &ServoModel) -> BTreeMap<String, f64> {
        let servo = described.bench.servo;
        named([("torque_limit_nm", servo.torque_limit_nm * values[0].exp())])
    }
}
