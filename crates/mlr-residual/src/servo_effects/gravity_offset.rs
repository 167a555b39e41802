use std::collections::BTreeMap;

use super::{EffectParameter, ServoEffect, effect::named};
use crate::{Prior, servo::ServoModel};

/// The bench is not level, or the arm is not where the servo thinks: the arm hangs at another reported
/// angle.
///
/// - `angle_rad`: added to the angle at which it hangs straight down.
/// - Prior: 0 ± 0.04 rad: a bench set up by eye, half a tooth of a horn. Assumed.
#[derive(Debug)]
pub(super) struct GravityOffset;

impl ServoEffect for GravityOffset {
    fn kind(&self) -> &'static str {
        "gravity_offset"
    }

    fn signature(&self) -> &'static str {
        "the arm comes to rest beside the bottom, and goes further to one side"
    }

    fn parameters(&self, _: &ServoModel) -> Vec<EffectParameter> {
        let prior = Prior::Normal {
            mean: 0.0,
            deviation: 0.04,
        };
        vec![
            EffectParameter::new("angle_rad", prior)
                .bounds(-1.0, 1.0)
                .neutral(0.0),
        ]
    }

    fn apply(&self, values: &[f64], model: &mut ServoModel) {
        model.bench.arm.hanging_rad += values[0];
    }

    fn report(&self, values: &[f64], _: &ServoModel) -> BTreeMap<String, f64> {
        named([("angle_rad", values[0])])
    }
}
