use std::collections::BTreeMap;

use super::{Place, WalkEffect, effect::named};
use crate::{
    Parameter,
    walk::{WalkModel, WalkRecord},
};

/// The gyroscope reports rates in another scale than its data sheet says.
#[derive(Debug)]
pub(super) struct GyroScale;

/// MPU6050 data sheet: sensitivity within 3 %, and within 2 % more over temperature. Models get
/// the swing of a damaged robot as wrong.
const USUAL: f64 = 0.04;
/// How far it is usually off, where it is off: twice the 3 %.
const USUAL_WHERE_OFF: f64 = 0.06;

impl WalkEffect for GyroScale {
    fn kind(&self) -> &'static str {
        "gyro_scale"
    }

    fn trace(&self) -> &'static str {
        "turns and fast swings are too large or too small by the same share"
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<Parameter> {
        let scale = Parameter::new("scale_less_1", 0.0);
        vec![scale.step(0.01).bounds(-0.5, 0.5).neutral(0.0).usual(USUAL)]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        vec![vec![-0.06], vec![0.06]]
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        model.sensing.scale *= 1.0 + values[0];
    }

    fn rarity(&self, values: &[f64]) -> f64 {
        (values[0] / USUAL_WHERE_OFF).powi(2)
    }

    fn report(&self, _: Place, values: &[f64], _: &WalkModel) -> BTreeMap<String, f64> {
        named([("scale", 1.0 + values[0])])
    }

    fn is_of_sensing(&self) -> bool {
        true
    }
}
