//! Orientation from raw samples.

use mlr_filter::{Axes, OrientationSeries, SeriesError, unwrapped_rad};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use vqf_rs::VQF;

/// Raw samples with a time stamp each.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RawSeries {
    /// Time stamps in seconds, as recorded.
    pub times_s: Vec<f64>,
    /// Specific force in m/s²; up is positive at rest.
    pub accelerations_mps2: Vec<Vector3<f64>>,
    /// Angular rate in rad/s.
    pub angular_rates_radps: Vec<Vector3<f64>>,
}

impl RawSeries {
    /// Fuses the samples into roll, pitch and unwrapped yaw. Yaw begins at zero:
    /// without a magnetometer its zero is arbitrary, and it drifts with what
    /// remains of the gyroscope's bias.
    ///
    /// # Errors
    /// [`SeriesError`] when the lists differ in length or hold no finite numbers.
    pub fn fuse(self) -> Result<OrientationSeries, SeriesError> {
        let bias = self.standing_bias_radps().unwrap_or_default();
        let mut fusion = Fusion::new(typical_step_s(&self.times_s), bias);
        let mut angles_rad = Axes::<Vec<f64>>::default();
        let samples = self
            .accelerations_mps2
            .iter()
            .zip(&self.angular_rates_radps);
        for (&time_s, (acceleration, rate)) in self.times_s.iter().zip(samples) {
            angles_rad.push(fusion.update(time_s, acceleration, rate));
        }
        OrientationSeries::new(self.times_s, angles_rad)
    }
}

impl RawSeries {
    /// The samples of these indices, in this order; indices beyond the end are left out.
    #[must_use]
    pub fn picked(&self, indices: &[usize]) -> Self {
        fn pick<T: Copy>(values: &[T], indices: &[usize]) -> Vec<T> {
            let picked = indices.iter().filter_map(|&index| values.get(index));
            picked.copied().collect()
        }
        Self {
            times_s: pick(&self.times_s, indices),
            accelerations_mps2: pick(&self.accelerations_mps2, indices),
            angular_rates_radps: pick(&self.angular_rates_radps, indices),
        }
    }

    /// Mean rates in rad/s about x, y, z between two times, if the sensor is at rest then.
    pub fn rest_rate_radps(&self, from_s: f64, to_s: f64) -> Option<Vector3<f64>> {
        let samples = self.times_s.iter().zip(&self.angular_rates_radps);
        let resting: Vec<Vector3<f64>> = samples
            .filter(|(time_s, _)| (from_s..to_s).contains(*time_s))
            .map(|(_, rate)| *rate)
            .collect();
        rest_bias_radps(&resting)
    }

    /// The gyroscope's bias: its mean over the first half second, if the sensor is
    /// at rest then.
    fn standing_bias_radps(&self) -> Option<Vector3<f64>> {
        let begin_s = self.times_s.first()?;
        let rates_radps: Vec<Vector3<f64>> = self
            .angular_rates_radps
            .iter()
            .zip(&self.times_s)
            .take_while(|(_, time_s)| **time_s - begin_s < CALIBRATION_S)
            .map(|(rate, _)| *rate)
            .collect();
        let covered = self.times_s.last()? - begin_s >= CALIBRATION_S;
        rest_bias_radps(&rates_radps).filter(|_| covered)
    }
}

/// The gyroscope's bias: the mean of its rates, if they show a sensor at rest.
pub fn rest_bias_radps(rates_radps: &[Vector3<f64>]) -> Option<Vector3<f64>> {
    let count = rates_radps.len() as f64;
    let mean = rates_radps.iter().sum::<Vector3<f64>>() / count;
    let variance = rates_radps
        .iter()
        .map(|rate| (rate - mean).component_mul(&(rate - mean)))
        .sum::<Vector3<f64>>()
        / count;
    let at_rest = variance.max().sqrt() < REST_DEVIATION_DPS.to_radians();
    let believable = mean.amax() < LARGEST_BIAS_DPS.to_radians();
    (rates_radps.len() >= MIN_CALIBRATION_SAMPLES && at_rest && believable).then_some(mean)
}

/// How long the sensor must rest for its bias to be taken.
pub const CALIBRATION_S: f64 = 0.5;
/// Samples that a mean needs.
const MIN_CALIBRATION_SAMPLES: usize = 10;
/// Standard deviation of the rate about any axis below which the sensor rests.
const REST_DEVIATION_DPS: f64 = 1.0;
/// Largest bias that is believed: the data sheet's zero-rate output.
const LARGEST_BIAS_DPS: f64 = 20.0;

/// A running estimate of orientation from acceleration and angular rate.
///
/// The filter is VQF: D. Laidig and T. Seel, *VQF: Highly accurate IMU orientation
/// estimation with bias estimation and magnetic disturbance rejection*, Information
/// Fusion 91 (2023).
pub struct Fusion {
    filter: VQF,
    bias_radps: Vector3<f64>,
    last_time_s: Option<f64>,
    last_yaw_rad: Option<f64>,
    first_yaw_rad: f64,
}

/// Longest step that a rate is held for, in seconds.
const LONGEST_STEP_S: f64 = 0.25;

impl Fusion {
    /// Samples will come about every `step_s`; each is taken with its own time.
    /// `bias_radps` is what the gyroscope shows at rest, as far as it is known; the
    /// filter finds what is left of it, up to 2 °/s.
    pub fn new(step_s: f64, bias_radps: Vector3<f64>) -> Self {
        Self {
            filter: VQF::new(step_s, None, None, None),
            bias_radps,
            last_time_s: None,
            last_yaw_rad: None,
            first_yaw_rad: 0.0,
        }
    }

    /// Takes a sample and returns roll, pitch and unwrapped yaw. A sample whose
    /// time is not later than the last one's changes nothing.
    pub fn update(
        &mut self,
        time_s: f64,
        acceleration_mps2: &Vector3<f64>,
        angular_rate_radps: &Vector3<f64>,
    ) -> Axes<f64> {
        let step_s = match self.last_time_s {
            Some(last_s) => (time_s - last_s).min(LONGEST_STEP_S),
            None => 0.0,
        };
        if step_s > 0.0 || self.last_time_s.is_none() {
            self.filter
                .update_gyr_with_ts((angular_rate_radps - self.bias_radps).into(), step_s);
            self.filter.update_acc((*acceleration_mps2).into());
            self.last_time_s = Some(time_s);
        }
        let q = self.filter.quat_6d();
        let orientation = UnitQuaternion::from_quaternion(Quaternion::new(q.0, q.1, q.2, q.3));
        let (roll, pitch, yaw) = orientation.euler_angles();
        let yaw = self.unwrapped(yaw);
        Axes { roll, pitch, yaw }
    }

    fn unwrapped(&mut self, yaw_rad: f64) -> f64 {
        let continued = match self.last_yaw_rad {
            Some(last) => unwrapped_rad(last, yaw_rad),
            None => {
                self.first_yaw_rad = yaw_rad;
                yaw_rad
            }
        };
        self.last_yaw_rad = Some(continued);
        continued - self.first_yaw_rad
    }
}

/// The median step; 10 ms when there is none.
fn typical_step_s(times_s: &[f64]) -> f64 {
    let mut steps: Vec<f64> = times_s
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .filter(|step| step.is_finite() && *step > 0.0)
        .collect();
    if steps.is_empty() {
        return 0.01;
    }
    let middle = steps.len() / 2;
    let (_, median, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
    *median
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A sensor that stands for two seconds and then rocks about x by 0.2 rad,
    /// while it turns about z, with a biased gyroscope.
    fn rocking(bias: Vector3<f64>, steps_s: &[f64]) -> (RawSeries, Vec<[f64; 3]>) {
        let mut raw = RawSeries::default();
        let mut truth = Vec::new();
        let mut t = 0.0;
        for step_s in steps_s.iter().cycle() {
            if t > 12.0 {
                break;
            }
            let walked_s: f64 = (t - 2.0_f64).max(0.0);
            let roll = 0.2 * (3.0 * walked_s).sin().powi(2);
            let roll_rate = if walked_s > 0.0 {
                0.2 * 3.0 * (6.0 * walked_s).sin()
            } else {
                0.0
            };
            let yaw_rate = if walked_s > 0.0 { 0.15 } else { 0.0 };
            let yaw = yaw_rate * walked_s;
            let attitude = UnitQuaternion::from_euler_angles(roll, 0.0, yaw);
            let body_rate =
                Vector3::x() * roll_rate + attitude.inverse() * (Vector3::z() * yaw_rate);
            raw.times_s.push(t);
            raw.accelerations_mps2
                .push(attitude.inverse() * (Vector3::z() * 9.81));
            raw.angular_rates_radps.push(body_rate + bias);
            truth.push([roll, 0.0, yaw]);
            t += step_s;
        }
        (raw, truth)
    }

    fn largest_error_rad(raw: RawSeries, truth: &[[f64; 3]]) -> [f64; 3] {
        let fused = raw.fuse().unwrap();
        let angles = fused.angles_rad();
        let mut errors = [0.0_f64; 3];
        for (index, expected) in truth.iter().enumerate() {
            let ours = [angles.roll[index], angles.pitch[index], angles.yaw[index]];
            for axis in 0..3 {
                errors[axis] = errors[axis].max((ours[axis] - expected[axis]).abs());
            }
        }
        errors
    }

    #[test]
    fn without_bias_the_motion_is_followed() {
        let (raw, truth) = rocking(Vector3::zeros(), &[0.001]);
        let errors = largest_error_rad(raw, &truth);
        assert!(errors.iter().all(|error| *error < 0.01), "{errors:?}");
    }

    #[test]
    fn a_bias_is_found_while_the_sensor_stands() {
        let bias = Vector3::new(-0.0061, 0.0056, -0.07);
        let (raw, truth) = rocking(bias, &[0.001]);
        let errors = largest_error_rad(raw, &truth);
        assert!(errors.iter().all(|error| *error < 0.01), "{errors:?}");
    }

    #[test]
    fn a_sensor_that_moves_is_not_taken_for_a_biased_one() {
        let (whole, truth) = rocking(Vector3::zeros(), &[0.001]);
        let from = 4000;
        let moving = RawSeries {
            times_s: whole.times_s[from..].to_vec(),
            accelerations_mps2: whole.accelerations_mps2[from..].to_vec(),
            angular_rates_radps: whole.angular_rates_radps[from..].to_vec(),
        };
        let turned_rad = truth[from][2];
        let later: Vec<[f64; 3]> = truth[from..]
            .iter()
            .map(|[roll, pitch, yaw]| [*roll, *pitch, yaw - turned_rad])
            .collect();
        let errors = largest_error_rad(moving, &later);
        assert!(errors.iter().all(|error| *error < 0.03), "{errors:?}");
    }

    #[test]
    fn repeated_and_backward_time_stamps_change_nothing() {
        let (mut raw, truth) = rocking(Vector3::zeros(), &[0.001]);
        raw.times_s[5000] = raw.times_s[4999];
        raw.times_s[6000] = raw.times_s[5990];
        let errors = largest_error_rad(raw, &truth);
        assert!(errors.iter().all(|error| *error < 0.02), "{errors:?}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(8))]
        #[test]
        fn uneven_steps_are_taken_as_they_are(steps_s in prop::collection::vec(0.000_5..0.002_5_f64, 50)) {
            let (raw, truth) = rocking(Vector3::zeros(), &steps_s);
            let errors = largest_error_rad(raw, &truth);
            prop_assert!(errors.iter().all(|error| *error < 0.02), "{errors:?}");
        }
    }
}
