use std::collections::BTreeMap;

use super::{EffectParameter, Place, WalkEffect, effect::named};
use crate::{
    Prior,
    walk::{Nuisance, WalkModel, WalkRecord},
};

/// The gyroscope reports rates at rest, and the orientation filter believes them.
///
/// - `x_dps`, `y_dps`, `z_dps`: the reported rate less the true one about the sensor's axes, in
///   °/s; a positive one about z turns the yaw to the left.
/// - `ln_filter_time`, where roll and pitch come from a filter: logarithm of the time for which it
///   trusts the gyroscope, over the described one. It says how far a bias about x and y tilts roll
///   and pitch. People read `filter_time_s`.
/// - Prior: 0 ± 2.5 °/s. The data sheet of the MPU-6050 allows 20 °/s before any calibration;
///   calibrated ones are off by some °/s once they are warm. The filter's time is known to a
///   factor of two: 0 ± 0.7.
/// - Bounds: ±20 °/s and ±2.
#[derive(Debug)]
pub(super) struct GyroBias;

impl WalkEffect for GyroBias {
    fn kind(&self) -> &'static str {
        "gyro_bias"
    }

    fn signature(&self) -> &'static str {
        "yaw drifts from the first sample on; roll and pitch wander off within the filter's time"
    }

    fn parameters(&self, _: Place, model: &WalkModel) -> Vec<EffectParameter> {
        let rate = |name| {
            let prior = Prior::Normal {
                mean: 0.0,
                deviation: 2.5,
            };
            EffectParameter::new(name, prior)
                .bounds(-20.0, 20.0)
                .neutral(0.0)
        };
        let mut parameters = vec![rate("x_dps"), rate("y_dps"), rate("z_dps")];
        if model.sensing.has_a_filter() {
            let prior = Prior::Normal {
                mean: 0.0,
                deviation: 0.7,
            };
            let filter_time = EffectParameter::new("ln_filter_time", prior);
            parameters.push(filter_time.bounds(-2.0, 2.0).neutral(0.0));
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

    fn replaces(&self, _: Place) -> Vec<Nuisance> {
        [0, 1, 2].map(Nuisance::Bias).into()
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
}
