use super::{Inapplicable, Parameter, SensorEffect};
use crate::{SensorRecord, SensorSignals, Track};

/// A scale that changes with the rate: `1 + share (rate / 100 °/s)²`.
#[derive(Debug)]
pub(super) struct ScaleNonlinearity;

impl SensorEffect for ScaleNonlinearity {
    fn kind(&self) -> &'static str {
        "scale_nonlinearity"
    }

    fn signature(&self) -> &'static str {
        "proportional to the angle turned fast"
    }

    fn parameters(&self, _: &SensorRecord) -> Result<Vec<Parameter>, Inapplicable> {
        Ok(vec![
            Parameter::new("share_at_100_dps", 0.0)
                .step(1e-5)
                .bounds(-0.02, 0.02)
                .neutral(0.0),
        ])
    }

    fn correct_rate(&self, values: &[f64], _: &SensorSignals, track: &mut Track) {
        for rate in &mut track.rate_dps {
            *rate *= 1.0 + values[0] * (*rate / 100.0).powi(2);
        }
    }
}
