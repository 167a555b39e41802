use super::{Commonness, Inapplicable, Parameter, SensorEffect};
use crate::{SensorRecord, SensorSignals, Track};

/// A constant zero-rate output: the gyroscope reports the true rate plus the bias,
/// in °/s and with the sign of the sensor's own axis.
#[derive(Debug)]
pub(super) struct GyroBias;

impl SensorEffect for GyroBias {
    fn kind(&self) -> &'static str {
        "gyro_bias"
    }

    fn commonness(&self) -> Commonness {
        Commonness::Always
    }

    fn signature(&self) -> &'static str {
        "grows in proportion to time, turning or not"
    }

    fn parameters(&self, fit_stretch: &SensorRecord) -> Result<Vec<Parameter>, Inapplicable> {
        let axis = fit_stretch.signals().axis;
        let name = axis.map_or("bias_dps".into(), |axis| format!("{}_dps", axis.letter()));
        Ok(vec![
            Parameter::new(name, 0.0)
                .step(1e-3)
                .bounds(-40.0, 40.0)
                .neutral(0.0),
        ])
    }

    fn correct_rate(&self, values: &[f64], signals: &SensorSignals, track: &mut Track) {
        for rate in &mut track.rate_dps {
            *rate -= signals.sign * values[0];
        }
    }
}
