use std::collections::BTreeMap;

use super::{Place, WalkEffect, effect::named};
use crate::{
    Parameter,
    walk::{WalkModel, WalkRecord},
};

/// The controller's clock runs fast or slow.
#[derive(Debug)]
pub(super) struct GaitPeriod;

impl WalkEffect for GaitPeriod {
    fn kind(&self) -> &'static str {
        "gait_period"
    }

    fn trace(&self) -> &'static str {
        "every swing comes later, or earlier, than the one before"
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<Parameter> {
        let scale = Parameter::new("scale_less_1", 0.0);
        vec![
            scale
                .step(0.003)
                .bounds(-0.3, 0.3)
                .neutral(0.0)
                .usual(0.005),
        ]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        let scales = [-0.07, -0.04, -0.015, 0.015, 0.04, 0.07];
        scales.map(|scale| vec![scale]).into()
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        model.gait.period_s *= 1.0 + values[0];
        model.gait.ramp_s *= 1.0 + values[0];
    }

    fn report(&self, _: Place, values: &[f64], _: &WalkModel) -> BTreeMap<String, f64> {
        named([("scale", 1.0 + values[0])])
    }
}
