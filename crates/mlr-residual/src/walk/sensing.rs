//! What the sensor makes of the body's orientation.

use mlr_filter::{Axes, MovingMean, OrientationSeries, unwrapped_rad};
use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};

use super::WalkRecord;

/// A gyroscope and an accelerometer, how they are mounted, and the filter that makes
/// roll, pitch and yaw of them. The default is a sensor without faults.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sensing {
    /// Roll and pitch at which the sensor is mounted on the body, degrees.
    pub misalignment_deg: [f64; 2],
    /// Rate about x, y, z that the gyroscope reports at rest, in degrees per second.
    pub bias_dps: [f64; 3],
    /// How fast the bias about z grows from the log's first sample on, in degrees per
    /// second and minute.
    pub drift_dps_per_min: f64,
    /// True rate over reported rate.
    pub scale: f64,
    /// How late the samples are.
    pub delay_s: f64,
    /// How long the filter trusts the gyroscope's roll and pitch before the
    /// accelerometer's.
    pub filter_time_s: f64,
}

impl Default for Sensing {
    fn default() -> Self {
        Self {
            misalignment_deg: [0.0; 2],
            bias_dps: [0.0; 3],
            drift_dps_per_min: 0.0,
            scale: 1.0,
            delay_s: 0.0,
            filter_time_s: 2.0,
        }
    }
}

impl Sensing {
    /// Roll, pitch and yaw in degrees that the sensor would report at the first
    /// `samples` times of the record, if the body moved as in `body`, whose time counts
    /// from the start of the walk. `clock` is the duration of the robot's gait over that
    /// of the body's.
    pub(crate) fn observe(
        &self,
        body: &OrientationSeries,
        clock: f64,
        record: &WalkRecord,
        samples: usize,
    ) -> Axes<Vec<f64>> {
        let means = MovingMean::new(body);
        let mut angles_deg = Axes::<Vec<f64>>::default();
        let mut previous: Option<Axes<f64>> = None;
        // What bias and scale have added to the angles so far.
        let mut added_deg = [0.0; 3];
        let first_s = record.times_s().first().copied().unwrap_or(0.0);
        for &time_s in &record.times_s()[..samples] {
            let gait_time_s = (time_s - record.start_s() - self.delay_s) / clock;
            let half_width_s = WalkRecord::HALF_WIDTH_S / clock;
            let mut seen = self.mounted(means.around(gait_time_s, half_width_s));
            if let Some(previous) = previous {
                seen.yaw = unwrapped_rad(previous.yaw, seen.yaw);
                let turned = seen.into_array();
                let before = previous.into_array();
                for axis in 0..3 {
                    let turned_deg = (turned[axis] - before[axis]).to_degrees();
                    let mut rate_dps = self.bias_dps[axis]
                        + turned_deg * (1.0 / self.scale - 1.0) / WalkRecord::PERIOD_S;
                    if axis == 2 {
                        rate_dps += self.drift_dps_per_min / 60.0 * (time_s - first_s);
                    } else {
                        rate_dps -= added_deg[axis] / self.filter_time_s;
                    }
                    added_deg[axis] += rate_dps * WalkRecord::PERIOD_S;
                }
            }
            previous = Some(seen);
            let axes = seen.into_array();
            let reported = [0, 1, 2].map(|axis| axes[axis].to_degrees() + added_deg[axis]);
            angles_deg.push(Axes {
                roll: reported[0],
                pitch: reported[1],
                yaw: reported[2],
            });
        }
        angles_deg
    }

    /// The orientation of the sensor on a body of this orientation.
    fn mounted(&self, body_rad: Axes<f64>) -> Axes<f64> {
        let [roll_deg, pitch_deg] = self.misalignment_deg;
        if roll_deg == 0.0 && pitch_deg == 0.0 {
            return body_rad;
        }
        let mount = rotation(roll_deg.to_radians(), pitch_deg.to_radians(), 0.0);
        let sensor = rotation(body_rad.roll, body_rad.pitch, body_rad.yaw) * mount;
        Axes {
            roll: libm::atan2(sensor[(2, 1)], sensor[(2, 2)]),
            pitch: -libm::asin(sensor[(2, 0)].clamp(-1.0, 1.0)),
            yaw: unwrapped_rad(body_rad.yaw, libm::atan2(sensor[(1, 0)], sensor[(0, 0)])),
        }
    }

    /// A sensor with the faults of both.
    #[must_use]
    pub fn and(self, other: &Self) -> Self {
        let mut both = self;
        for (sum, more) in both.misalignment_deg.iter_mut().zip(other.misalignment_deg) {
            *sum += more;
        }
        for (sum, more) in both.bias_dps.iter_mut().zip(other.bias_dps) {
            *sum += more;
        }
        both.drift_dps_per_min += other.drift_dps_per_min;
        both.scale *= other.scale;
        both.delay_s += other.delay_s;
        both
    }

    /// The body's orientation as a recording of this sensor shows it: without what
    /// scale, bias about z and its drift add to the yaw, and without the delay. Roll and
    /// pitch lose what scale and bias add to them in the long run.
    ///
    /// # Panics
    /// Never: the corrections of finite angles are finite.
    pub fn correct(&self, recording: &OrientationSeries) -> OrientationSeries {
        let first_s = recording.times_s().first().copied().unwrap_or(0.0);
        let times_s = recording.times_s().iter().map(|t| t - self.delay_s);
        let corrected = recording.angles_rad().as_ref().map(|axis, angles| {
            let samples = recording.times_s().iter().zip(angles);
            samples
                .map(|(time_s, angle_rad)| {
                    let since_s = time_s - first_s;
                    let added_deg = match axis {
                        mlr_filter::Axis::Yaw => {
                            self.bias_dps[2] * since_s
                                + 0.5 * self.drift_dps_per_min / 60.0 * since_s * since_s
                        }
                        mlr_filter::Axis::Roll => self.misalignment_deg[0],
                        mlr_filter::Axis::Pitch => self.misalignment_deg[1],
                    };
                    self.scale * (angle_rad - added_deg.to_radians())
                })
                .collect::<Vec<f64>>()
        });
        OrientationSeries::new(times_s.collect(), corrected)
            .expect("a finite series less finite corrections is finite")
    }
}

fn rotation(roll_rad: f64, pitch_rad: f64, yaw_rad: f64) -> Matrix3<f64> {
    let [(sr, cr), (sp, cp), (sy, cy)] = [roll_rad, pitch_rad, yaw_rad].map(libm::sincos);
    let x = Matrix3::new(1.0, 0.0, 0.0, 0.0, cr, -sr, 0.0, sr, cr);
    let y = Matrix3::new(cp, 0.0, sp, 0.0, 1.0, 0.0, -sp, 0.0, cp);
    let z = Matrix3::new(cy, -sy, 0.0, sy, cy, 0.0, 0.0, 0.0, 1.0);
    z * y * x
}
