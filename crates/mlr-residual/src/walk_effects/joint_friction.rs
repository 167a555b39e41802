use std::collections::BTreeMap;

use super::{EffectParameter, Place, WalkEffect, effect::named};
use crate::{
    Prior,
    walk::{WalkModel, WalkRecord},
};

/// The gears of all servos have dry friction: worn, dirty, or tightened too far.
///
/// - `torque_nm`: dry friction of every joint beyond the described one, at rest and in motion.
/// - Prior: 0.03 ± 0.02 of the torque limit. Assumed: published fits of geared servos lie between 0.01
///   and 0.1.
/// - Bounds: 0 to 0.3 of the torque limit.
#[derive(Debug)]
pub(super) struct JointFriction;

impl WalkEffect for JointFriction {
    fn kind(&self) -> &'static str {
        "joint_friction"
    }

    fn signature(&self) -> &'static str {
        "the body stays where it was put: it gives way later, and swings back less"
    }

    fn parameters(&self, _: Place, model: &WalkModel) -> Vec<EffectParameter> {
        let limit_nm = model.servo.torque_limit_nm;
        let prior = Prior::Normal {
            mean: 0.03 * limit_nm,
            deviation: 0.02 * limit_nm,
        };
        vec![
            EffectParameter::new("torque_nm", prior)
                .bounds(0.0, 0.3 * limit_nm)
                .neutral(0.0),
        ]
    }

    fn starts(&self, _: Place, model: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        vec![vec![0.03 * model.servo.torque_limit_nm]]
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        model.servo.drive.coulomb_nm += values[0];
    }

    fn report(&self, _: Place, values: &[f64], _: &WalkModel) -> BTreeMap<String, f64> {
        named([("torque_nm", values[0])])
    }
}
