use super::{Inapplicable, Parameter, SensorEffect};
use crate::{SensorRecord, SensorSignals, Track};

/// Five times what data sheets of such gyroscopes give (0.1 °/s per g). More would
/// stand in for a bias or for gravity.
const MAX_DPS_PER_G: f64 = 0.5;

/// A rate reported because of acceleration; °/s per g along x, y and z, with the sign
/// of the sensor's own axis.
#[derive(Debug)]
pub(super) struct GSensitivity;

impl SensorEffect for GSensitivity {
    fn kind(&self) -> &'static str {
        "g_sensitivity"
    }

    fn signature(&self) -> &'static str {
        "grows where the sensor tilts or shakes"
    }

    fn parameters(&self, fit_stretch: &SensorRecord) -> Result<Vec<Parameter>, Inapplicable> {
        if fit_stretch.signals().accelerations_g.is_none() {
            return Err(Inapplicable("the log has no accelerations of this sensor"));
        }
        let parameter = |name| {
            Parameter::new(name, 0.0)
                .step(1e-3)
                .bounds(-MAX_DPS_PER_G, MAX_DPS_PER_G)
                .neutral(0.0)
        };
        Ok(["x_dps_per_g", "y_dps_per_g", "z_dps_per_g"]
            .map(parameter)
            .into())
    }

    fn correct_rate(&self, values: &[f64], signals: &SensorSignals, track: &mut Track) {
        let Some(accelerations_g) = &signals.accelerations_g else {
            return;
        };
        for (along, dps_per_g) in accelerations_g.iter().zip(values) {
            for (rate, g) in track.rate_dps.iter_mut().zip(along) {
                *rate -= signals.sign * dps_per_g * g;
            }
        }
    }
}
