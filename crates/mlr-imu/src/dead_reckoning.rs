//! Orientation from the rates alone.

use std::ops::Range;

use mlr_filter::{Axes, OrientationSeries, unwrapped_rad};
use nalgebra::{UnitQuaternion, Vector3};

use crate::RawSeries;

/// Longest step over which a rate says how far the sensor turned.
const LONGEST_STEP_S: f64 = 0.05;
/// Samples that the mean acceleration at rest needs.
const LEAST_SAMPLES: usize = 10;

impl RawSeries {
    /// Roll, pitch and unwrapped yaw from the beginning of `rest_s` on, by integrating the
    /// rates as they are: their bias at rest included. Roll and pitch begin with the tilt that
    /// the accelerometer shows while the sensor rests during `rest_s`, yaw with zero.
    ///
    /// Over half a minute that is truer than what filters that listen to the accelerometer
    /// make of a body that lurches: they take its accelerations for tilt.
    ///
    /// `None` where there are too few samples at rest, and where times run backwards or leave
    /// more than 50 ms out.
    pub fn dead_reckoned(&self, rest_s: Range<f64>) -> Option<OrientationSeries> {
        let begin = self
            .times_s
            .partition_point(|time_s| *time_s < rest_s.start);
        let end = self.times_s.partition_point(|time_s| *time_s < rest_s.end);
        let resting = self.accelerations_mps2.get(begin..end)?;
        if resting.len() < LEAST_SAMPLES {
            return None;
        }
        let up = resting.iter().sum::<Vector3<f64>>() / resting.len() as f64;
        let (roll, pitch) = (up.y.atan2(up.z), (-up.x).atan2(up.y.hypot(up.z)));
        let mut attitude = UnitQuaternion::from_euler_angles(roll, pitch, 0.0);
        let mut angles_rad = Axes::<Vec<f64>>::default();
        angles_rad.push(Axes {
            roll,
            pitch,
            yaw: 0.0,
        });
        let times_s = &self.times_s[begin..];
        let rates = self.angular_rates_radps.get(begin..)?;
        let mut last_yaw = 0.0;
        for (times_s, rates) in times_s.windows(2).zip(rates.windows(2)) {
            let step_s = times_s[1] - times_s[0];
            if !(step_s > 0.0 && step_s <= LONGEST_STEP_S) {
                return None;
            }
            let turned = (rates[0] + rates[1]) * (0.5 * step_s);
            attitude *= UnitQuaternion::from_scaled_axis(turned);
            let (roll, pitch, yaw) = attitude.euler_angles();
            last_yaw = unwrapped_rad(last_yaw, yaw);
            angles_rad.push(Axes {
                roll,
                pitch,
                yaw: last_yaw,
            });
        }
        OrientationSeries::new(times_s.to_vec(), angles_rad).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE_HZ: f64 = 500.0;

    /// A sensor that stands for 2 s at a roll of 0.1 rad and then rocks about its y axis while
    /// it turns about the vertical; `push_mps2` is what its accelerometer adds to gravity while
    /// it moves.
    fn rocking(push_mps2: f64, bias: Vector3<f64>) -> (RawSeries, Vec<Axes<f64>>) {
        let mut raw = RawSeries::default();
        let mut truth = Vec::new();
        let attitude = |time_s: f64| {
            let moving_s = (time_s - 2.0).max(0.0);
            let pitch = 0.2 * (1.0 - (3.0 * moving_s).cos());
            UnitQuaternion::from_euler_angles(0.1, pitch, 0.3 * moving_s)
        };
        for index in 0..(12.0 * RATE_HZ) as u32 {
            let time_s = f64::from(index) / RATE_HZ;
            let near_s = 0.5e-4;
            let (before, now, after) = (
                attitude(time_s - near_s),
                attitude(time_s),
                attitude(time_s + near_s),
            );
            let rate = (before.inverse() * after).scaled_axis() / (2.0 * near_s);
            let push = if time_s < 2.0 { 0.0 } else { push_mps2 };
            let force = now.inverse() * (Vector3::z() * 9.81) + Vector3::x() * push;
            raw.times_s.push(time_s);
            raw.angular_rates_radps.push(rate + bias);
            raw.accelerations_mps2.push(force);
            let (roll, pitch, yaw) = now.euler_angles();
            truth.push(Axes { roll, pitch, yaw });
        }
        (raw, truth)
    }

    fn largest_tilt_error_rad(reckoned: &OrientationSeries, truth: &[Axes<f64>]) -> f64 {
        let angles = reckoned.angles_rad();
        let tilts = angles.roll.iter().zip(&angles.pitch);
        let errors = tilts
            .zip(truth)
            .map(|((roll, pitch), truth)| (roll - truth.roll).hypot(pitch - truth.pitch));
        errors.fold(0.0, f64::max)
    }

    #[test]
    fn follows_the_attitude_whatever_pushes_the_body() {
        let (raw, truth) = rocking(3.0, Vector3::zeros());
        let reckoned = raw.dead_reckoned(0.0..1.9).unwrap();
        assert!(largest_tilt_error_rad(&reckoned, &truth) < 1e-4);
        let yaw = reckoned.angles_rad().yaw.last().unwrap();
        assert!((yaw - 3.0).abs() < 0.01, "{yaw}");
        let fused = raw.fuse().unwrap();
        assert!(largest_tilt_error_rad(&fused, &truth) > 0.01);
    }

    #[test]
    fn a_bias_stays_in() {
        let bias_radps = 0.01;
        let (raw, _) = rocking(0.0, Vector3::z() * bias_radps);
        let (unbiased, _) = rocking(0.0, Vector3::zeros());
        let yaw = |raw: &RawSeries| {
            let reckoned = raw.dead_reckoned(1.0..1.9).unwrap();
            let yaw = &reckoned.angles_rad().yaw;
            // Until the sensor moves.
            yaw[(0.9 * RATE_HZ) as usize]
        };
        assert!((yaw(&raw) - yaw(&unbiased) - 0.9 * bias_radps).abs() < 1e-4);
    }

    #[test]
    fn gaps_and_a_sensor_that_is_never_seen_at_rest_are_refused() {
        let (mut raw, _) = rocking(0.0, Vector3::zeros());
        assert_eq!(raw.dead_reckoned(0.0..0.001), None);
        assert_eq!(raw.dead_reckoned(20.0..21.0), None);
        raw.times_s.iter_mut().skip(3000).for_each(|t| *t += 0.1);
        assert_eq!(raw.dead_reckoned(0.0..1.9), None);
        assert_eq!(RawSeries::default().dead_reckoned(0.0..1.0), None);
    }
}
