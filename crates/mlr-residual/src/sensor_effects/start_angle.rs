use super::{Commonness, Inapplicable, Parameter, SensorEffect};
use crate::{SensorRecord, SensorSignals, Track};

/// The reference's first reading is off: the angle starts at the reading plus this
/// many degrees.
#[derive(Debug)]
pub(super) struct StartAngle;

impl SensorEffect for StartAngle {
    fn kind(&self) -> &'static str {
        "start_angle"
    }

    fn commonness(&self) -> Commonness {
        Commonness::Always
    }

    fn signature(&self) -> &'static str {
        "constant"
    }

    fn parameters(&self, _: &SensorRecord) -> Result<Vec<Parameter>, Inapplicable> {
        Ok(vec![
            Parameter::new("offset_deg", 0.0)
                .step(1e-3)
                .bounds(-180.0, 180.0)
                .neutral(0.0),
        ])
    }

    fn correct_angle(&self, values: &[f64], _: &SensorSignals, track: &mut Track) {
        for angle in &mut track.angle_deg {
            *angle += values[0];
        }
    }
}
