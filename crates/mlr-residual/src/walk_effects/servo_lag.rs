use std::collections::BTreeMap;

use super::{EffectParameter, Place, WalkEffect, effect::named};
use crate::walk::{Nuisance, WalkModel, WalkRecord};

/// The servos take longer than described to begin to follow a command.
///
/// - `delay_s`: the additional latency, in seconds.
/// - Prior: 0.05 ± 0.03 s: a busy controller or bus adds a command tick of 20 ms or a few. Assumed,
///   not measured.
/// - Bounds: 0 to 0.5 s.
#[derive(Debug)]
pub(super) struct ServoLag;

impl WalkEffect for ServoLag {
    fn kind(&self) -> &'static str {
        "servo_lag"
    }

    fn signature(&self) -> &'static str {
        "everything is done later than it was commanded"
    }

    fn parameters(&self, _: Place, _: &WalkModel) -> Vec<EffectParameter> {
        vec![EffectParameter::delay()]
    }

    fn starts(&self, _: Place, _: &WalkModel, _: &WalkRecord) -> Vec<Vec<f64>> {
        vec![vec![0.05]]
    }

    fn apply(&self, _: Place, values: &[f64], model: &mut WalkModel) {
        model.servo.latency_s += values[0];
    }

    fn replaces(&self, _: Place) -> Vec<Nuisance> {
        vec![Nuisance::Start]
    }

    fn report(&self, _: Place, values: &[f64], _: &WalkModel) -> BTreeMap<String, f64> {
        named([("delay_s", values[0])])
    }

    fn is_a_delay(&self) -> bool {
        true
    }
}
