use std::collections::BTreeMap;

use super::{EffectParameter, Place, WalkEffect, effect::named};
use crate::{
    Prior,
    walk::{Nuisance, WalkModel, WalkRecord},
};

/// The gears of all servos have play: each joint is free over an angle about where its motor holds it.
///
/// - `angle_rad`: the whole angle, beyond what robots of the make have.
/// - Prior: 0.02 ± 0.013 rad: worn servos have a degree or two, where new ones have a quarter to half
///   a degree. Assumed.
/// - Bounds: 0 to 0.15 rad.
#[derive(Debug)]
pub(super) struct Backlash;

impl WalkEffect for Backlash {
    fn kind(&self) -> &'static str {
        "backlash"
    }

    fn signature(&self) -> &'static str {
        "the body falls a little further wherever the load of a leg changes its side"
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<EffectParameter> {
        let prior = Prior::Normal {
            mean: 0.02,
            deviation: 0.013,
        };
        vec![
            EffectParameter::new("angle_rad", prior)
                .bounds(0.0, 0.15)
                .neutral(0.0),
        ]
    }

    fn replaces(&self, _: Place) -> Vec<Nuisance> {
        vec![Nuisance::Backlash]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        vec![vec![0.02]]
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        model.servo.drive.backlash_rad += values[0];
    }

    fn report(&self, _: Place, values: &[f64], _: &WalkModel) -> BTreeMap<String, f64> {
        named([("angle_rad", values[0])])
    }
}
