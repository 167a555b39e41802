use std::collections::BTreeMap;

use super::{
    Place, WalkEffect,
    effect::{delay, named},
};
use crate::{
    Parameter,
    walk::{WalkModel, WalkRecord},
};

/// The samples are stamped late.
#[derive(Debug)]
pub(super) struct SensorDelay;

impl WalkEffect for SensorDelay {
    fn kind(&self) -> &'static str {
        "sensor_delay"
    }

    fn trace(&self) -> &'static str {
        "everything is seen later than it was commanded"
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<Parameter> {
        vec![delay()]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        vec![vec![0.05]]
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        model.sensing.delay_s += values[0];
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
