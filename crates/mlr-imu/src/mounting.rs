//! How the sensor sits on the robot, and what its accelerometer gets wrong.

use mlr_filter::SettingError;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::ImuSample;

/// How a sensor is mounted and calibrated; by default along the body's axes, and
/// taken at its word.
///
/// ```
/// use mlr_imu::{ImuSample, Mounting};
/// use nalgebra::Vector3;
///
/// // Turned by a quarter to the left: the sensor's x axis points along body y.
/// let mounting = Mounting { yaw_deg: 90.0, ..Mounting::default() };
/// let sample = ImuSample {
///     angular_rate_radps: Some(Vector3::x()),
///     ..ImuSample::default()
/// };
/// let rate = mounting.in_body_axes(&sample).angular_rate_radps.unwrap();
/// assert!((rate - Vector3::y()).norm() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Mounting {
    /// Roll of the sensor relative to the body (REP-103, R = Rz·Ry·Rx).
    pub roll_deg: f64,
    /// Its pitch.
    pub pitch_deg: f64,
    /// Its yaw.
    pub yaw_deg: f64,
    /// What the accelerometer shows in free fall, in the sensor's axes.
    pub accelerometer_bias_mps2: [f64; 3],
    /// Rows of the matrix that turns the accelerometer's readings, less their
    /// bias, into specific force: scale and misalignment of its axes.
    pub accelerometer_scale: [[f64; 3]; 3],
}

impl Default for Mounting {
    fn default() -> Self {
        Self {
            roll_deg: 0.0,
            pitch_deg: 0.0,
            yaw_deg: 0.0,
            accelerometer_bias_mps2: [0.0; 3],
            accelerometer_scale: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        }
    }
}

/// Largest bias of an accelerometer that is believed, in m/s².
const LARGEST_BIAS_MPS2: f64 = 5.0;
/// The scale matrix of an accelerometer is near the identity: no entry is larger than this,
/// and its determinant stays within these bounds.
const LARGEST_ENTRY: f64 = 2.0;
const DETERMINANT: std::ops::RangeInclusive<f64> = 0.5..=2.0;

impl Mounting {
    /// Checks every number.
    ///
    /// # Errors
    /// [`SettingError`] names the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        for (name, angle_deg) in [
            ("roll_deg", self.roll_deg),
            ("pitch_deg", self.pitch_deg),
            ("yaw_deg", self.yaw_deg),
        ] {
            SettingError::check(name, angle_deg, -360.0..=360.0, "degrees")?;
        }
        SettingError::check_each(
            "accelerometer_bias_mps2",
            &self.accelerometer_bias_mps2,
            -LARGEST_BIAS_MPS2..=LARGEST_BIAS_MPS2,
            "m/s²",
        )?;
        for (row, entries) in self.accelerometer_scale.iter().enumerate() {
            let name = format!("accelerometer_scale[{row}]");
            SettingError::check_each(&name, entries, -LARGEST_ENTRY..=LARGEST_ENTRY, "")?;
        }
        let determinant = self.scale().determinant();
        if DETERMINANT.contains(&determinant) {
            Ok(())
        } else {
            Err(SettingError::new(
                "accelerometer_scale",
                format!("a determinant of {determinant}"),
                "a matrix near the identity, with a determinant of 0.5 to 2",
            ))
        }
    }

    /// The sample as a calibrated sensor along the body's axes would have taken it.
    pub fn in_body_axes(&self, sample: &ImuSample) -> ImuSample {
        let body_from_sensor = self.body_from_sensor();
        let bias = Vector3::from(self.accelerometer_bias_mps2);
        ImuSample {
            acceleration_mps2: sample
                .acceleration_mps2
                .map(|reading| body_from_sensor * (self.scale() * (reading - bias))),
            angular_rate_radps: sample
                .angular_rate_radps
                .map(|rate| body_from_sensor * rate),
            orientation: sample
                .orientation
                .map(|world_from_sensor| world_from_sensor * body_from_sensor.inverse()),
            ..*sample
        }
    }

    fn body_from_sensor(&self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_euler_angles(
            self.roll_deg.to_radians(),
            self.pitch_deg.to_radians(),
            self.yaw_deg.to_radians(),
        )
    }

    fn scale(&self) -> Matrix3<f64> {
        let rows = self.accelerometer_scale;
        Matrix3::from_fn(|row, column| rows[row][column])
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn orientation_of_the_body_does_not_depend_on_the_mounting() {
        let mounting = Mounting {
            roll_deg: 180.0,
            pitch_deg: 10.0,
            yaw_deg: -35.0,
            ..Mounting::default()
        };
        let body = UnitQuaternion::from_euler_angles(0.2, -0.1, 1.0);
        let sensor = body * mounting.body_from_sensor();
        let sample = ImuSample {
            orientation: Some(sensor),
            acceleration_mps2: Some(sensor.inverse() * (Vector3::z() * 9.81)),
            ..ImuSample::default()
        };
        let ours = mounting.in_body_axes(&sample);
        assert!(ours.orientation.unwrap().angle_to(&body) < 1e-12);
        let up = body * ours.acceleration_mps2.unwrap();
        assert!((up - Vector3::z() * 9.81).norm() < 1e-12);
    }

    #[test]
    fn nonsense_is_named() {
        let flat = Mounting {
            accelerometer_scale: [[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
            ..Mounting::default()
        };
        assert_eq!(flat.check().unwrap_err().name, "accelerometer_scale");
        let unknown = Mounting {
            pitch_deg: f64::NAN,
            ..Mounting::default()
        };
        assert_eq!(unknown.check().unwrap_err().name, "pitch_deg");
        Mounting::default().check().unwrap();
    }

    proptest! {
        #[test]
        fn calibration_undoes_what_the_sensor_does(
            force in prop::array::uniform3(-20.0..20.0_f64),
            bias in prop::array::uniform3(-3.0..3.0_f64),
            gains in prop::array::uniform3(0.9..1.1_f64),
        ) {
            let mounting = Mounting {
                accelerometer_bias_mps2: bias,
                accelerometer_scale: [
                    [1.0 / gains[0], 0.0, 0.0],
                    [0.0, 1.0 / gains[1], 0.0],
                    [0.0, 0.0, 1.0 / gains[2]],
                ],
                ..Mounting::default()
            };
            mounting.check().unwrap();
            let truth = Vector3::from(force);
            let reading = truth.component_mul(&Vector3::from(gains)) + Vector3::from(bias);
            let sample = ImuSample { acceleration_mps2: Some(reading), ..ImuSample::default() };
            let ours = mounting.in_body_axes(&sample).acceleration_mps2.unwrap();
            prop_assert!((ours - truth).norm() < 1e-9);
        }
    }
}
