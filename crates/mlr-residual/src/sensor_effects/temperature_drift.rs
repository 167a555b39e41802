use super::{Commonness, Inapplicable, Parameter, SensorEffect};
use crate::{SensorRecord, SensorSignals, Track};

/// A bias that follows the sensor's temperature, zero at the temperature of the
/// first sample; °/s per °C with the sign of the sensor's own axis.
#[derive(Debug)]
pub(super) struct TemperatureDrift;

impl SensorEffect for TemperatureDrift {
    fn kind(&self) -> &'static str {
        "temperature_drift"
    }

    fn commonness(&self) -> Commonness {
        Commonness::Usual
    }

    fn signature(&self) -> &'static str {
        "grows with the integral of the temperature"
    }

    fn parameters(&self, fit_stretch: &SensorRecord) -> Result<Vec<Parameter>, Inapplicable> {
        if fit_stretch.signals().temperature_c.is_none() {
            return Err(Inapplicable("the log has no temperature"));
        }
        Ok(vec![
            Parameter::new("dps_per_c", 0.0)
                .step(1e-3)
                .bounds(-5.0, 5.0)
                .neutral(0.0),
        ])
    }

    fn correct_rate(&self, values: &[f64], signals: &SensorSignals, track: &mut Track) {
        let Some(temperature_c) = &signals.temperature_c else {
            return;
        };
        let start_c = temperature_c.first().copied().unwrap_or(0.0);
        for (rate, now_c) in track.rate_dps.iter_mut().zip(temperature_c) {
            *rate -= signals.sign * values[0] * (now_c - start_c);
        }
    }
}
