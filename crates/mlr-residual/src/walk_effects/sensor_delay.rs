use std::collections::BTreeMap;

use super::{EffectParameter, Place, WalkEffect, effect::named};
use crate::walk::{Nuisance, WalkModel, WalkRecord};

/// The samples are stamped later than they were taken.
///
/// - `delay_s`: stamped time less true time, in seconds.
/// - Prior: 0.05 ± 0.03 s: a serial buffer or an onboard filter holds samples back by tens of
///   milliseconds. Assumed, not measured.
/// - Bounds: 0 to 0.5 s.
#[derive(Debug)]
pub(super) struct SensorDelay;

impl WalkEffect for SensorDelay {
    fn kind(&self) -> &'static str {
        "sensor_delay"
    }

    fn signature(&self) -> &'static str {
        "everything is seen later than it was commanded"
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<EffectParameter> {
        vec![EffectParameter::delay()]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        vec![vec![0.05]]
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        model.sensing.delay_s += values[0];
    }

    fn replaces(&self, _: Place) -> Vec<Nuisance> {
        vec![Nuisance::Start]
    }

    fn report(&self, _: Place, values: &[f64], _: &WalkModel) -> BTreeMap<String, f64> {
        named([("delay_s", values[0])])
    }

    fn is_of_sensing(&self) -> bool {
        true
    }

    fn is_a_delay(&self) -> bool {
        true
    }
}
