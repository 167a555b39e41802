use std::collections::BTreeMap;

use super::{Place, WalkEffect, effect::named};
use crate::{
    Parameter,
    walk::{WalkModel, WalkRecord},
};

/// The gyroscope's bias about z grows, as while it warms up.
#[derive(Debug)]
pub(super) struct BiasDrift;

impl WalkEffect for BiasDrift {
    fn kind(&self) -> &'static str {
        "bias_drift"
    }

    fn trace(&self) -> &'static str {
        "yaw bends like a parabola from the first sample on"
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<Parameter> {
        let drift = Parameter::new("dps_per_min", 0.0);
        vec![
            drift
                .step(0.5)
                .bounds(-120.0, 120.0)
                .neutral(0.0)
                .usual(2.0),
        ]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        vec![vec![-8.0], vec![8.0]]
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        model.sensing.drift_dps_per_min += values[0];
    }

    fn report(&self, _: Place, values: &[f64], _: &WalkModel) -> BTreeMap<String, f64> {
        named([("dps_per_min", values[0])])
    }

    fn is_of_sensing(&self) -> bool {
        true
    }
}
