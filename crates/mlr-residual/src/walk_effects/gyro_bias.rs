use std::collections::BTreeMap;

use super::{Place, WalkEffect, effect::named};
use crate::{
    Parameter,
    walk::{WalkModel, WalkRecord},
};

/// The gyroscope reports a rate at rest, and the orientation filter believes it.
#[derive(Debug)]
pub(super) struct GyroBias;

impl WalkEffect for GyroBias {
    fn kind(&self) -> &'static str {
        "gyro_bias"
    }

    fn trace(&self) -> &'static str {
        "yaw drifts from the first sample on; roll and pitch wander off within the filter's time"
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<Parameter> {
        let rate = |name| {
            Parameter::new(name, 0.0)
                .step(0.1)
                .bounds(-20.0, 20.0)
                .neutral(0.0)
                .usual(0.3)
        };
        vec![
            rate("x_dps"),
            rate("y_dps"),
            rate("z_dps"),
            Parameter::new("ln_filter_time", 0.0)
                .step(0.1)
                .bounds(-2.0, 2.0)
                .neutral(0.0)
                .usual(f64::INFINITY),
        ]
    }

    fn starts(&self, _: Place, _: &WalkModel, record: &WalkRecord) -> Vec<Vec<f64>> {
        let [x, y, z] = record.rest_rate_dps().unwrap_or([0.1; 3]);
        vec![vec![x, y, z, 0.0]]
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        for (bias_dps, value) in model.sensing.bias_dps.iter_mut().zip(values) {
            *bias_dps += value;
        }
        model.sensing.filter_time_s *= values[3].exp();
    }

    fn report(&self, _: Place, values: &[f64], model: &WalkModel) -> BTreeMap<String, f64> {
        named([
            ("x_dps", values[0]),
            ("y_dps", values[1]),
            ("z_dps", values[2]),
            (
                "filter_time_s",
                model.sensing.filter_time_s * values[3].exp(),
            ),
        ])
    }

    fn is_of_sensing(&self) -> bool {
        true
    }
}
