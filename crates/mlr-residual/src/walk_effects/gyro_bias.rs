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

    fn parameters(&self, _: Place, model: &WalkModel) -> Vec<Parameter> {
        let rate = |name| {
            Parameter::new(name, 0.0)
                .step(0.1)
                .bounds(-20.0, 20.0)
                .neutral(0.0)
                .usual(0.3)
        };
        let mut parameters = vec![rate("x_dps"), rate("y_dps"), rate("z_dps")];
        if model.sensing.has_a_filter() {
            parameters.push(
                Parameter::new("ln_filter_time", 0.0)
                    .step(0.1)
                    .bounds(-2.0, 2.0)
                    .neutral(0.0)
                    .usual(f64::INFINITY),
            );
        }
        parameters
    }

    fn starts(&self, _: Place, model: &WalkModel, record: &WalkRecord) -> Vec<Vec<f64>> {
        let mut start = record.rest_rate_dps().unwrap_or([0.1; 3]).to_vec();
        if model.sensing.has_a_filter() {
            start.push(0.0);
        }
        vec![start]
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        for (bias_dps, value) in model.sensing.bias_dps.iter_mut().zip(values) {
            *bias_dps += value;
        }
        if let Some(ln_factor) = values.get(3) {
            model.sensing.filter_time_s *= ln_factor.exp();
        }
    }

    fn report(&self, _: Place, values: &[f64], model: &WalkModel) -> BTreeMap<String, f64> {
        let names = ["x_dps", "y_dps", "z_dps", "filter_time_s"];
        let mut reported = named(names.into_iter().zip(values.iter().copied()));
        if let Some(filter_time_s) = reported.get_mut("filter_time_s") {
            *filter_time_s = model.sensing.filter_time_s * filter_time_s.exp();
        }
        reported
    }

    fn is_of_sensing(&self) -> bool {
        true
    }

    fn shows_at_rest(&self) -> bool {
        true
    }
}
