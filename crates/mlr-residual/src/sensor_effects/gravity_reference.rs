use super::{Commonness, Inapplicable, Parameter, SensorEffect};
use crate::{SensorRecord, SensorSignals, Track};

/// Mean acceleration across the shaft from which on gravity tells its angle.
const MIN_LENGTH_G: f64 = 0.3;
/// Accelerations across the shaft that differ by more from 1 g are left out.
const MAX_EXCESS_G: f64 = 0.35;

/// Direction of gravity about the rate's axis in degrees, growing as the reference
/// does, and the acceleration across that axis in g.
fn gravity_angles(signals: &SensorSignals) -> Option<Vec<(f64, f64)>> {
    let axis = signals.axis?;
    let along = signals.accelerations_g.as_ref()?;
    // A turn by θ about x moves the direction up from z towards y in the body frame.
    let (towards, from) = (axis.next(), axis.next().next());
    let pairs = along[towards as usize].iter().zip(&along[from as usize]);
    let angle = |(a, b): (&f64, &f64)| (signals.sign * a.atan2(*b).to_degrees(), a.hypot(*b));
    Some(pairs.map(angle).collect())
}

/// Gravity tells the angle about a level axis. The accelerometer is noisy and feels
/// vibration, so the angle follows it only over a time constant in s and the
/// gyroscope in between (a complementary filter). `offset_deg` is what the
/// accelerometer's angle reads when the reference reads zero: the mean over the fitted
/// stretch, since in a joint fit it could not be told from the gyroscope's bias.
#[derive(Debug)]
pub(super) struct GravityReference;

impl SensorEffect for GravityReference {
    fn kind(&self) -> &'static str {
        "gravity_reference"
    }

    fn commonness(&self) -> Commonness {
        Commonness::Usual
    }

    fn signature(&self) -> &'static str {
        "a drift that gravity sees and the rate does not"
    }

    fn parameters(&self, fit_stretch: &SensorRecord) -> Result<Vec<Parameter>, Inapplicable> {
        let Some(angles) = gravity_angles(fit_stretch.signals()) else {
            return Err(Inapplicable("the log has no accelerations of this sensor"));
        };
        let length_g = angles.iter().map(|(_, length_g)| length_g).sum::<f64>();
        if length_g < MIN_LENGTH_G * angles.len() as f64 {
            return Err(Inapplicable(
                "the shaft stands upright, gravity does not see it turn",
            ));
        }
        // The circular mean of the differences.
        let (mut sine, mut cosine) = (0.0, 0.0);
        for ((angle_deg, _), reference_deg) in angles.iter().zip(fit_stretch.angle_deg()) {
            let difference = (angle_deg - reference_deg).to_radians();
            sine += difference.sin();
            cosine += difference.cos();
        }
        Ok(vec![
            Parameter::new("time_constant_s", 3.0)
                .step(1e-3)
                .bounds(0.05, 1000.0),
            Parameter::new("offset_deg", sine.atan2(cosine).to_degrees()).fixed(),
        ])
    }

    fn correct_angle(&self, values: &[f64], signals: &SensorSignals, track: &mut Track) {
        let Some(gravity) = gravity_angles(signals) else {
            return;
        };
        let mut correction = 0.0;
        for (i, (gravity_deg, length_g)) in gravity.into_iter().enumerate() {
            let integrated = track.angle_deg[i];
            let step_s = match i {
                0 => 0.0,
                _ => track.times_s[i] - track.times_s[i - 1],
            };
            // Only what is close to 1 g is gravity.
            if (length_g - 1.0).abs() < MAX_EXCESS_G {
                let error = gravity_deg - values[1] - (integrated + correction);
                let wrapped = error - 360.0 * (error / 360.0).round();
                correction += (step_s / values[0]).min(1.0) * wrapped;
            }
            track.angle_deg[i] = integrated + correction;
        }
    }

    fn observes_drift(&self) -> bool {
        true
    }
}
