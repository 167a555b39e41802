use std::collections::BTreeMap;

use super::{EffectParameter, ServoEffect, effect::named};
use crate::servo::ServoModel;

/// The motor's torque falls with its speed, at the limit as well.
///
/// - `ln_damping`: logarithm of the torque per speed over the described damping. People read
///   `damping_nm_s_per_rad`.
/// - Prior: 0 ± 0.6: the ratio of stall torque and no-load speed of a data sheet, which have tolerances of
///   a tenth each and include friction. Assumed.
#[derive(Debug)]
pub(super) struct BackEmf;

impl ServoEffect for BackEmf {
    fn kind(&self) -> &'static str {
        "back_emf"
    }

    fn signature(&self) -> &'static str {
        "fast motions at the limit are too fast"
    }

    fn parameters(&self, _: &ServoModel) -> Vec<EffectParameter> {
        vec![EffectParameter::ln("ln_damping", 1.0, 0.6)]
    }

    fn start_coordinates(&self) -> &'static [f64] {
        &[-1.0, 0.0, 1.0]
    }

    fn apply(&self, values: &[f64], model: &mut ServoModel) {
        model.bench.servo.drive.back_emf = true;
        model.bench.servo.damping_nm_s_per_rad *= values[0].exp();
    }

    fn report(&self, values: &[f64], described: &ServoModel) -> BTreeMap<String, f64> {
        let damping = described.bench.servo.damping_nm_s_per_rad;
        named([("damping_nm_s_per_rad", damping * values[0].exp())])
    }
}
