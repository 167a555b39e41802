use std::collections::BTreeMap;

use super::{
    Place, WalkEffect,
    effect::{delay, named},
};
use crate::{
    Parameter,
    walk::{WalkModel, WalkRecord},
};

/// The servos take longer than usual to begin to follow a command.
#[derive(Debug)]
pub(super) struct ServoLag;

impl WalkEffect for ServoLag {
    fn kind(&self) -> &'static str {
        "servo_lag"
    }

    fn trace(&self) -> &'static str {
        "everything is done later than it was commanded"
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<Parameter> {
        vec![delay()]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        vec![vec![0.05]]
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        model.servo.latency_s += values[0];
    }

    fn report(&self, _: Place, values: &[f64], _: &WalkModel) -> BTreeMap<String, f64> {
        named([("delay_s", values[0])])
    }

    fn is_a_delay(&self) -> bool {
        true
    }
}
