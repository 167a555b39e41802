use super::{Commonness, Inapplicable, Parameter, SensorEffect};
use crate::{SensorRecord, SensorSignals, Track};

/// A bias that changes linearly with time, zero at the first sample; °/s per minute
/// with the sign of the sensor's own axis.
#[derive(Debug)]
pub(super) struct BiasDrift;

impl SensorEffect for BiasDrift {
    fn kind(&self) -> &'static str {
        "bias_drift"
    }

    fn commonness(&self) -> Commonness {
        Commonness::Usual
    }

    fn signature(&self) -> &'static str {
        "grows with the square of time"
    }

    fn parameters(&self, _: &SensorRecord) -> Result<Vec<Parameter>, Inapplicable> {
        Ok(vec![
            Parameter::new("dps_per_min", 0.0)
                .step(1e-3)
                .bounds(-20.0, 20.0)
                .neutral(0.0),
        ])
    }

    fn correct_rate(&self, values: &[f64], signals: &SensorSignals, track: &mut Track) {
        let start_s = signals.times_s.first().copied().unwrap_or(0.0);
        for (rate, time_s) in track.rate_dps.iter_mut().zip(&signals.times_s) {
            *rate -= signals.sign * values[0] * (time_s - start_s) / 60.0;
        }
    }
}
