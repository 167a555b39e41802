use std::collections::BTreeMap;

use super::{EffectParameter, Place, WalkEffect, effect::named};
use crate::{
    Prior,
    walk::{WalkModel, WalkRecord},
};

/// The gyroscope's bias about z grows from the log's first sample on, as while the chip warms up.
///
/// - `dps_per_min`: growth of the reported rate about z, in °/s per minute; positive turns the
///   yaw further to the left.
/// - Prior: 0 ± 12 °/s per minute. The data sheet of the MPU-6050 allows 20 °/s over -40 to
///   85 °C, 0.16 °/s per °C, so that a chip that warms by some °C per minute drifts by 1 °/s per
///   minute; a drift that counts as a fault is assumed to be about ten times that.
/// - Bounds: ±120 °/s per minute.
#[derive(Debug)]
pub(super) struct BiasDrift;

impl WalkEffect for BiasDrift {
    fn kind(&self) -> &'static str {
        "bias_drift"
    }

    fn signature(&self) -> &'static str {
        "yaw bends like a parabola from the first sample on"
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<EffectParameter> {
        let prior = Prior::Normal {
            mean: 0.0,
            deviation: 12.0,
        };
        vec![
            EffectParameter::new("dps_per_min", prior)
                .bounds(-120.0, 120.0)
                .neutral(0.0),
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
