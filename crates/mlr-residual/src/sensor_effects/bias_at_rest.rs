use super::rest::{at_rest, rest_bias_dps};
use super::{Commonness, Inapplicable, Parameter, SensorEffect};
use crate::{SensorRecord, SensorSignals, Track};

/// The bias is read off whenever the sensor stands still, by the sensor's own signals,
/// and kept until the next rest; what the reading remembers fades over `memory_s` of
/// rest. While still, the angle is held.
#[derive(Debug)]
pub(super) struct BiasAtRest;

impl SensorEffect for BiasAtRest {
    fn kind(&self) -> &'static str {
        "bias_at_rest"
    }

    fn commonness(&self) -> Commonness {
        Commonness::Usual
    }

    fn signature(&self) -> &'static str {
        "a drift whose slope changes from rest to rest"
    }

    fn parameters(&self, fit_stretch: &SensorRecord) -> Result<Vec<Parameter>, Inapplicable> {
        if rest_bias_dps(fit_stretch.signals()).is_none() {
            return Err(Inapplicable("the sensor is never at rest"));
        }
        Ok(vec![
            Parameter::new("memory_s", 2.0)
                .step(1e-2)
                .bounds(0.1, 600.0),
        ])
    }

    fn correct_rate(&self, values: &[f64], signals: &SensorSignals, track: &mut Track) {
        let mut bias = 0.0;
        let mut rested_s = 0.0;
        for (i, at_rest) in at_rest(signals).into_iter().enumerate() {
            if at_rest && i > 0 {
                let step_s = track.times_s[i] - track.times_s[i - 1];
                rested_s += step_s;
                bias += step_s / rested_s.min(values[0]).max(step_s) * (track.rate_dps[i] - bias);
                track.rate_dps[i] = 0.0;
            } else {
                track.rate_dps[i] -= bias;
            }
        }
    }

    fn observes_drift(&self) -> bool {
        true
    }
}
