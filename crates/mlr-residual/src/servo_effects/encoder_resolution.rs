use std::collections::BTreeMap;

use super::{EffectParameter, ServoEffect};
use crate::servo::ServoModel;

/// The servo reports multiples of its encoder's step, which is the smallest change in a recording.
///
/// It has no parameters.
#[derive(Debug)]
pub(super) struct EncoderResolution;

impl ServoEffect for EncoderResolution {
    fn kind(&self) -> &'static str {
        "encoder_resolution"
    }

    fn signature(&self) -> &'static str {
        "angles come in steps"
    }

    fn parameters(&self, _: &ServoModel) -> Vec<EffectParameter> {
        Vec::new()
    }

    fn apply(&self, _: &[f64], model: &mut ServoModel) {
        model.rounds = true;
    }

    fn report(&self, _: &[f64], _: &ServoModel) -> BTreeMap<String, f64> {
        BTreeMap::new()
    }
}
