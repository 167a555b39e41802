use super::{Inapplicable, Parameter, SensorEffect};
use crate::{SensorRecord, SensorSignals, Track};

/// Play between the sensor and the reference: the angle turns by the width, in degrees,
/// before the reference follows. The reference then lags behind the sensor by half of
/// it in either direction.
#[derive(Debug)]
pub(super) struct Backlash;

impl SensorEffect for Backlash {
    fn kind(&self) -> &'static str {
        "backlash"
    }

    fn signature(&self) -> &'static str {
        "steps where the direction turns"
    }

    fn parameters(&self, _: &SensorRecord) -> Result<Vec<Parameter>, Inapplicable> {
        Ok(vec![
            Parameter::new("width_deg", 0.1)
                .step(1e-3)
                .bounds(0.0, 5.0)
                .neutral(0.0),
        ])
    }

    fn correct_angle(&self, values: &[f64], _: &SensorSignals, track: &mut Track) {
        let half_deg = values[0] / 2.0;
        let Some(mut followed) = track.angle_deg.first().copied() else {
            return;
        };
        for angle in &mut track.angle_deg {
            followed = followed.clamp(*angle - half_deg, *angle + half_deg);
            *angle = followed;
        }
    }
}
