use super::{Commonness, Inapplicable, Parameter, SensorEffect};
use crate::{SensorRecord, SensorSignals, Track};

/// A scale factor beside the data sheet's: true rate / reported rate. A wrong scale
/// of the reference looks the same.
#[derive(Debug)]
pub(super) struct GyroScale;

impl SensorEffect for GyroScale {
    fn kind(&self) -> &'static str {
        "gyro_scale"
    }

    fn commonness(&self) -> Commonness {
        Commonness::Always
    }

    fn signature(&self) -> &'static str {
        "proportional to the angle turned"
    }

    fn parameters(&self, _: &SensorRecord) -> Result<Vec<Parameter>, Inapplicable> {
        Ok(vec![
            Parameter::new("scale", 1.0)
                .step(1e-5)
                .bounds(0.8, 1.25)
                .neutral(1.0),
        ])
    }

    fn correct_rate(&self, values: &[f64], _: &SensorSignals, track: &mut Track) {
        for rate in &mut track.rate_dps {
            *rate *= values[0];
        }
    }
}
