use std::collections::BTreeMap;

use super::{EffectParameter, ServoEffect, effect::named};
use crate::servo::ServoModel;

/// Dry friction of the gears that does not depend on speed or load.
///
/// - `ln_share`: logarithm of the friction over the torque limit. People read `coulomb_nm`.
/// - Prior: median 0.03, a factor of 2.7 either way. Assumed.
#[derive(Debug)]
pub(super) struct CoulombFriction;

impl ServoEffect for CoulombFriction {
    fn kind(&self) -> &'static str {
        "coulomb_friction"
    }

    fn signature(&self) -> &'static str {
        "the joint stops where it should turn back a little, and swings end at rest"
    }

    fn parameters(&self, _: &ServoModel) -> Vec<EffectParameter> {
        vec![EffectParameter::ln("ln_share", 0.03, 1.0)]
    }

    fn apply(&self, values: &[f64], model: &mut ServoModel) {
        model.bench.servo.drive.coulomb_nm = coulomb_nm(values, model);
    }

    fn report(&self, values: &[f64], described: &ServoModel) -> BTreeMap<String, f64> {
        named([("coulomb_nm", coulomb_nm(values, described))])
    }
}

fn coulomb_nm(values: &[f64], model: &ServoModel) -> f64 {
    model.described_limit_nm() * values[0].exp()
}
