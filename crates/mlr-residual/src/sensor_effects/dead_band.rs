use super::{Inapplicable, Parameter, SensorEffect};
use crate::{SensorRecord, SensorSignals, Track};

/// Rates below a width, in °/s, are reported as zero, and greater ones less by the
/// width.
#[derive(Debug)]
pub(super) struct DeadBand;

impl SensorEffect for DeadBand {
    fn kind(&self) -> &'static str {
        "dead_band"
    }

    fn signature(&self) -> &'static str {
        "grows with the time spent turning, against the turn"
    }

    fn parameters(&self, _: &SensorRecord) -> Result<Vec<Parameter>, Inapplicable> {
        Ok(vec![
            Parameter::new("width_dps", 0.1)
                .step(1e-3)
                .bounds(0.0, 1.0)
                .neutral(0.0),
        ])
    }

    fn correct_rate(&self, values: &[f64], _: &SensorSignals, track: &mut Track) {
        for rate in &mut track.rate_dps {
            // What lies below the width cannot be brought back.
            if rate.abs() > values[0] {
                *rate += values[0] * rate.signum();
            }
        }
    }
}
