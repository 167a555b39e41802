use std::collections::BTreeMap;

use super::{EffectParameter, ServoEffect, effect::named};
use crate::{Prior, servo::ServoModel};

/// The servo acts later than it is commanded to.
///
/// - `delay_s`: beyond the described latency.
/// - Prior: 0.01 ± 0.01 s: one or two cycles of a bus. Bounds: 0 to 0.1 s.
#[derive(Debug)]
pub(super) struct CommandDelay;

impl ServoEffect for CommandDelay {
    fn kind(&self) -> &'static str {
        "command_delay"
    }

    fn signature(&self) -> &'static str {
        "the whole motion comes later"
    }

    fn parameters(&self, _: &ServoModel) -> Vec<EffectParameter> {
        let prior = Prior::Normal {
            mean: 0.01,
            deviation: 0.01,
        };
        vec![
            EffectParameter::new("delay_s", prior)
                .bounds(0.0, 0.1)
                .neutral(0.0),
        ]
    }

    fn apply(&self, values: &[f64], model: &mut ServoModel) {
        model.bench.servo.latency_s += values[0];
    }

    fn report(&self, values: &[f64], _: &ServoModel) -> BTreeMap<String, f64> {
        named([("delay_s", values[0])])
    }
}
