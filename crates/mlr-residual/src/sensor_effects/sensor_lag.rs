use super::{Inapplicable, Parameter, SensorEffect};
use crate::{SensorRecord, SensorSignals, Track};

/// The sensor's low-pass filter: the rate follows with a time constant in s, so that
/// the angle is the integral plus the time constant times the rate.
#[derive(Debug)]
pub(super) struct SensorLag;

impl SensorEffect for SensorLag {
    fn kind(&self) -> &'static str {
        "sensor_lag"
    }

    fn signature(&self) -> &'static str {
        "proportional to the rate"
    }

    fn parameters(&self, _: &SensorRecord) -> Result<Vec<Parameter>, Inapplicable> {
        Ok(vec![
            Parameter::new("time_constant_s", 0.005)
                .step(1e-4)
                .bounds(0.0, 0.1)
                .neutral(0.0),
        ])
    }

    fn correct_rate(&self, values: &[f64], _: &SensorSignals, track: &mut Track) {
        let start_dps = track.rate_dps.first().copied().unwrap_or(0.0);
        track.start_deg -= values[0] * start_dps;
    }

    fn correct_angle(&self, values: &[f64], _: &SensorSignals, track: &mut Track) {
        for (angle, rate) in track.angle_deg.iter_mut().zip(&track.rate_dps) {
            *angle += values[0] * rate;
        }
    }
}
