use super::{Inapplicable, Parameter, SensorEffect};
use crate::{SensorRecord, SensorSignals, Track};

/// A scale that differs between the two directions: `1 + asymmetry` where the angle
/// grows, `1 - asymmetry` where it shrinks.
#[derive(Debug)]
pub(super) struct AsymmetricScale;

impl SensorEffect for AsymmetricScale {
    fn kind(&self) -> &'static str {
        "asymmetric_scale"
    }

    fn signature(&self) -> &'static str {
        "grows with every turn, in either direction"
    }

    fn parameters(&self, _: &SensorRecord) -> Result<Vec<Parameter>, Inapplicable> {
        Ok(vec![
            Parameter::new("asymmetry", 0.0)
                .step(1e-5)
                .bounds(-0.02, 0.02)
                .neutral(0.0),
        ])
    }

    fn correct_rate(&self, values: &[f64], _: &SensorSignals, track: &mut Track) {
        for rate in &mut track.rate_dps {
            *rate += values[0] * rate.abs();
        }
    }
}
