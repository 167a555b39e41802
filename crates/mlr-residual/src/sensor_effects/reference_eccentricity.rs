use super::{Inapplicable, Parameter, SensorEffect};
use crate::{SensorRecord, SensorSignals, Track};

/// An eccentric encoder disc or a bent shaft: the reference is off by
/// `sine_deg` times the sine of the angle plus `cosine_deg` times its cosine.
#[derive(Debug)]
pub(super) struct ReferenceEccentricity;

impl SensorEffect for ReferenceEccentricity {
    fn kind(&self) -> &'static str {
        "reference_eccentricity"
    }

    fn signature(&self) -> &'static str {
        "repeats with every revolution"
    }

    fn parameters(&self, _: &SensorRecord) -> Result<Vec<Parameter>, Inapplicable> {
        let parameter = |name| {
            Parameter::new(name, 0.0)
                .step(1e-3)
                .bounds(-0.5, 0.5)
                .neutral(0.0)
        };
        Ok(["sine_deg", "cosine_deg"].map(parameter).into())
    }

    fn correct_angle(&self, values: &[f64], _: &SensorSignals, track: &mut Track) {
        for angle in &mut track.angle_deg {
            let (sine, cosine) = angle.to_radians().sin_cos();
            *angle += values[0] * sine + values[1] * cosine;
        }
    }
}
