//! What the sensor makes of the body's orientation.

use mlr_filter::{Axes, MovingMean, OrientationSeries, unwrapped_rad};
use nalgebra::{UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::WalkRecord;

/// A gyroscope and an accelerometer, how they are mounted, and the filter that makes
/// roll, pitch and yaw of them. The default is a sensor without faults.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Sensing {
    /// Roll, pitch and yaw at which the sensor is mounted on the body, degrees.
    pub misalignment_deg: [f64; 3],
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
    /// accelerometer's; infinite where nothing but the rates counts.
    pub filter_time_s: f64,
    /// How far roll and pitch were off at the first sample where nothing corrects them
    /// afterwards, degrees: an error about the axes that the body had then.
    #[serde(skip)]
    pub level_deg: [f64; 2],
}

impl Default for Sensing {
    fn default() -> Self {
        Self {
            misalignment_deg: [0.0; 3],
            bias_dps: [0.0; 3],
            drift_dps_per_min: 0.0,
            scale: 1.0,
            delay_s: 0.0,
            filter_time_s: 2.0,
            level_deg: [0.0; 2],
        }
    }
}

impl Sensing {
    /// Whether a filter draws roll and pitch to what the accelerometer shows.
    pub(crate) fn has_a_filter(&self) -> bool {
        self.filter_time_s.is_finite()
    }

    /// Roll, pitch and yaw in degrees that the sensor would report at the first
    /// `samples` times of the record, if the body moved as in `body`, whose time counts
    /// from the start of the walk. `clock` is the duration of the robot's gait over that
    /// of the body's.
    ///
    /// The reported rates are integrated, as sensors do: what is added to them about one
    /// axis turns with the body.
    pub(crate) fn observe(
        &self,
        body: &OrientationSeries,
        clock: f64,
        record: &WalkRecord,
        samples: usize,
    ) -> Axes<Vec<f64>> {
        let means = MovingMean::new(body);
        let [level_roll_deg, level_pitch_deg] = self.level_deg;
        let level = attitude(
            level_roll_deg.to_radians(),
            level_pitch_deg.to_radians(),
            0.0,
        );
        let [roll_rad, pitch_rad, mount_yaw_rad] = self.misalignment_deg.map(f64::to_radians);
        let mount = attitude(roll_rad, pitch_rad, mount_yaw_rad);
        let mut angles_deg = Axes::<Vec<f64>>::default();
        // The sensor's true attitude and the one that it reckons with.
        let mut previous: Option<(UnitQuaternion<f64>, UnitQuaternion<f64>)> = None;
        let mut yaw_rad = 0.0;
        let first_s = record.times_s().first().copied().unwrap_or(0.0);
        for &time_s in &record.times_s()[..samples] {
            let gait_time_s = (time_s - record.start_s() - self.delay_s) / clock;
            let half_width_s = WalkRecord::HALF_WIDTH_S / clock;
            let seen = means.around(gait_time_s, half_width_s);
            let sensor = attitude(seen.roll, seen.pitch, seen.yaw) * mount;
            let mut reckoned = match previous {
                None => level * sensor,
                Some((before, reckoned)) => {
                    let turned = (before.inverse() * sensor).scaled_axis() / self.scale;
                    let added = self.added_radps(time_s - first_s) * WalkRecord::PERIOD_S;
                    reckoned * UnitQuaternion::from_scaled_axis(turned + added)
                }
            };
            let (mut roll, mut pitch, yaw) = reckoned.euler_angles();
            yaw_rad = unwrapped_rad(yaw_rad, yaw);
            if self.has_a_filter() {
                let (true_roll, true_pitch, _) = sensor.euler_angles();
                // In the long run a rate adds itself times the filter's time.
                let share = WalkRecord::PERIOD_S / (self.filter_time_s + WalkRecord::PERIOD_S);
                roll += share * (unwrapped_rad(roll, true_roll) - roll);
                pitch += share * (true_pitch - pitch);
                reckoned = attitude(roll, pitch, yaw);
            }
            previous = Some((sensor, reckoned));
            angles_deg.push(Axes {
                roll: roll.to_degrees(),
                pitch: pitch.to_degrees(),
                // Where yaw has its zero is arbitrary: it stays that of the body.
                yaw: (yaw_rad - mount_yaw_rad).to_degrees(),
            });
        }
        angles_deg
    }

    /// What the gyroscope adds to the rates so long after the first sample.
    fn added_radps(&self, since_s: f64) -> Vector3<f64> {
        let [x_dps, y_dps, z_dps] = self.bias_dps;
        let drifted_dps = self.drift_dps_per_min / 60.0 * since_s;
        Vector3::new(x_dps, y_dps, z_dps + drifted_dps).map(f64::to_radians)
    }

    /// The mean rates about x, y and z that the gyroscope would report while the robot of
    /// the record stands.
    pub(crate) fn rest_rate_dps(&self, record: &WalkRecord) -> [f64; 3] {
        let standing_s = record.standing().len() as f64 * WalkRecord::PERIOD_S;
        let [x_dps, y_dps, z_dps] = self.bias_dps;
        let drifted_dps = self.drift_dps_per_min / 60.0 * standing_s / 2.0;
        [x_dps, y_dps, z_dps + drifted_dps]
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
    /// pitch lose the tilt of the mounting and what scale adds to them, but not what a bias
    /// about x and y adds through the sensor's own filter: a constant, in the long run.
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

/// R = Rz(yaw) Ry(pitch) Rx(roll).
fn attitude(roll_rad: f64, pitch_rad: f64, yaw_rad: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_euler_angles(roll_rad, pitch_rad, yaw_rad)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body that stands for 2 s, then rolls by 5° and turns at 3°/s.
    fn body() -> OrientationSeries {
        let times_s: Vec<f64> = (-20..1200).map(|i| f64::from(i) * 0.01).collect();
        let walked = |t: f64| t.max(0.0);
        let angles_rad = Axes {
            roll: times_s
                .iter()
                .map(|t| 5.0_f64.to_radians() * (6.0 * walked(*t)).sin())
                .collect(),
            pitch: vec![0.0; times_s.len()],
            yaw: times_s
                .iter()
                .map(|t| 3.0_f64.to_radians() * walked(*t))
                .collect(),
        };
        OrientationSeries::new(times_s, angles_rad).unwrap()
    }

    fn record() -> WalkRecord {
        let times_s: Vec<f64> = (0..1200).map(|i| f64::from(i) * 0.01).collect();
        let still = vec![0.0; times_s.len()];
        let recording = OrientationSeries::new(times_s, Axes::from_fn(|_| still.clone())).unwrap();
        WalkRecord::new(&recording, 2.0, true, 2.0, None).unwrap()
    }

    fn observed(sensing: Sensing) -> Axes<Vec<f64>> {
        let record = record();
        sensing.observe(&body(), 1.0, &record, record.times_s().len())
    }

    #[test]
    fn a_perfect_sensor_shows_the_body() {
        let seen = observed(Sensing::default());
        let last = seen.yaw.len() - 1;
        let walked_s = record().times_s()[last] - 2.0;
        assert!((seen.yaw[last] - 3.0 * walked_s).abs() < 0.1);
        assert!(seen.pitch.iter().all(|pitch| pitch.abs() < 1e-9));
        assert!(seen.roll[..45].iter().all(|roll| roll.abs() < 1e-9));
    }

    #[test]
    fn a_tilted_sensor_shows_its_tilt_whatever_the_heading() {
        let seen = observed(Sensing {
            misalignment_deg: [3.0, -2.0, 0.0],
            ..Sensing::default()
        });
        let plain = observed(Sensing::default());
        for index in [10, 100, 200, 250] {
            assert!((seen.roll[index] - plain.roll[index] - 3.0).abs() < 0.1);
            assert!(
                (seen.pitch[index] + 2.0).abs() < 0.5,
                "{}",
                seen.pitch[index]
            );
        }
    }

    #[test]
    fn a_bias_turns_the_yaw_and_tilts_by_the_filters_time() {
        let seen = observed(Sensing {
            bias_dps: [2.0, 0.0, -1.0],
            filter_time_s: 0.5,
            ..Sensing::default()
        });
        let plain = observed(Sensing::default());
        let last = seen.yaw.len() - 1;
        let elapsed_s = last as f64 * WalkRecord::PERIOD_S;
        // But for what the tilt about x makes of the rates.
        assert!((seen.yaw[last] - plain.yaw[last] + elapsed_s).abs() < 0.1);
        assert!((seen.roll[last] - plain.roll[last] - 2.0 * 0.5).abs() < 0.05);
    }

    #[test]
    fn without_a_filter_a_bias_grows_and_turns_with_the_body() {
        let reckoned = |bias_dps: [f64; 3]| {
            observed(Sensing {
                bias_dps,
                filter_time_s: f64::INFINITY,
                ..Sensing::default()
            })
        };
        let (seen, plain) = (reckoned([0.5, 0.0, 0.0]), reckoned([0.0; 3]));
        let at = |time_s: f64| (time_s / WalkRecord::PERIOD_S) as usize;
        let off = |axis: fn(&Axes<Vec<f64>>) -> &Vec<f64>, index: usize| {
            axis(&seen)[index] - axis(&plain)[index]
        };
        // The body stands for 2 s, and then turns at 3 °/s.
        assert!((off(|a| &a.roll, at(2.0)) - 1.0).abs() < 0.05);
        let last = seen.roll.len() - 1;
        let walked_s = record().times_s()[last] - 2.0;
        let turn_rad = (3.0 * walked_s).to_radians();
        // What was added before has stayed in the ground's frame.
        let turned_rad = 3.0_f64.to_radians();
        let roll_deg = turn_rad.cos() + 0.5 * turn_rad.sin() / turned_rad;
        let pitch_deg = -turn_rad.sin() - 0.5 * (1.0 - turn_rad.cos()) / turned_rad;
        assert!(
            (off(|a| &a.roll, last) - roll_deg).abs() < 0.2,
            "{roll_deg}"
        );
        assert!(
            (off(|a| &a.pitch, last) - pitch_deg).abs() < 0.2,
            "{pitch_deg}"
        );
    }

    #[test]
    fn a_level_that_is_off_stays_where_it_is_while_the_body_turns() {
        let reckoned = |level_deg: [f64; 2]| {
            observed(Sensing {
                level_deg,
                filter_time_s: f64::INFINITY,
                ..Sensing::default()
            })
        };
        let (seen, plain) = (reckoned([1.0, 0.0]), reckoned([0.0; 2]));
        assert!((seen.roll[10] - plain.roll[10] - 1.0).abs() < 0.01);
        let last = seen.roll.len() - 1;
        let walked_s = record().times_s()[last] - 2.0;
        let turn_rad = (3.0 * walked_s).to_radians();
        assert!((seen.roll[last] - plain.roll[last] - turn_rad.cos()).abs() < 0.05);
        assert!((seen.pitch[last] - plain.pitch[last] + turn_rad.sin()).abs() < 0.1);
    }

    #[test]
    fn a_scale_shows_turns_larger_and_a_drift_bends_them() {
        let plain = observed(Sensing::default());
        let last = plain.yaw.len() - 1;
        let scaled = observed(Sensing {
            scale: 0.8,
            ..Sensing::default()
        });
        assert!((scaled.yaw[last] - plain.yaw[last] / 0.8).abs() < 0.1);
        let drifting = observed(Sensing {
            drift_dps_per_min: 12.0,
            ..Sensing::default()
        });
        let elapsed_s = last as f64 * WalkRecord::PERIOD_S;
        let bent = 0.5 * 12.0 / 60.0 * elapsed_s * elapsed_s;
        assert!((drifting.yaw[last] - plain.yaw[last] - bent).abs() < 0.1);
    }

    #[test]
    fn what_is_corrected_is_what_was_observed() {
        let sensing = Sensing {
            misalignment_deg: [3.0, -2.0, 0.0],
            bias_dps: [0.0, 0.0, 1.5],
            delay_s: 0.04,
            ..Sensing::default()
        };
        let seen = observed(sensing);
        let times_s = record().times_s().to_vec();
        let in_rad = |angles_deg: &[f64]| angles_deg.iter().map(|a| a.to_radians()).collect();
        let axes = seen.as_ref().map(|_, angles_deg| in_rad(angles_deg));
        let corrected = sensing.correct(&OrientationSeries::new(times_s, axes).unwrap());
        let plain = observed(Sensing::default());
        let means = MovingMean::new(&corrected);
        for index in [20, 100, 200] {
            let now = means.around(record().times_s()[index], 0.0);
            assert!((now.yaw.to_degrees() - plain.yaw[index]).abs() < 0.2);
            assert!((now.roll.to_degrees() - plain.roll[index]).abs() < 0.3);
        }
    }

    #[test]
    fn a_drift_shows_in_the_rates_at_rest() {
        let drifting = Sensing {
            bias_dps: [0.1, 0.0, 0.5],
            drift_dps_per_min: 12.0,
            ..Sensing::default()
        };
        let [x_dps, _, z_dps] = drifting.rest_rate_dps(&record());
        assert_eq!(x_dps, 0.1);
        // In the middle of the two seconds that it stands, the drift has added 0.2 °/s.
        assert!((z_dps - 0.7).abs() < 0.02, "{z_dps}");
    }

    #[test]
    fn two_faulty_sensors_in_one() {
        let one = Sensing {
            bias_dps: [1.0, 0.0, 0.0],
            scale: 1.1,
            ..Sensing::default()
        };
        let both = one.and(&one);
        assert_eq!(both.bias_dps, [2.0, 0.0, 0.0]);
        assert!((both.scale - 1.21).abs() < 1e-12);
        assert_eq!(one.and(&Sensing::default()), one);
    }
}
