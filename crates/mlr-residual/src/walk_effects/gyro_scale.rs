use std::collections::BTreeMap;

use super::{EffectParameter, Place, WalkEffect, effect::named};
use crate::{
    Prior,
    walk::{Nuisance, WalkModel, WalkRecord},
};

/// The gyroscope's scale is not that of its data sheet.
///
/// - `scale_less_1`: true rate over reported rate, less 1; where it is positive, turns are
///   reported smaller than they are. People read `scale`.
/// - Prior: 0 ± 0.07. The data sheet of the MPU-6050 allows 3 %, and 2 % more over temperature:
///   a scale that counts as a fault is off by more than these.
/// - Bounds: ±0.5.
#[derive(Debug)]
pub(super) struct GyroScale;

impl WalkEffect for GyroScale {
    fn kind(&self) -> &'static str {
        "gyro_scale"
    }

    fn signature(&self) -> &'static str {
        "turns and fast swings are too large or too small by the same share"
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<EffectParameter> {
        let prior = Prior::Normal {
            mean: 0.0,
            deviation: 0.07,
        };
        vec![
            EffectParameter::new("scale_less_1", prior)
                .bounds(-0.5, 0.5)
                .neutral(0.0),
        ]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        vec![vec![-0.06], vec![0.06]]
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        model.sensing.scale *= 1.0 + values[0];
    }

    fn replaces(&self, _: Place) -> Vec<Nuisance> {
        vec![Nuisance::Scale]
    }

    fn standing_for(&self, changes: &[f64]) -> Option<Vec<f64>> {
        Some(vec![changes.first()?.exp_m1()])
    }

    fn report(&self, _: Place, values: &[f64], _: &WalkModel) -> BTreeMap<String, f64> {
        named([("scale", 1.0 + values[0])])
    }

    fn is_of_sensing(&self) -> bool {
        true
    }
}
