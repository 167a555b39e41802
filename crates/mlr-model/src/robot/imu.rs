//! The IMU on the body.

use mlr_filter::OrientationSeries;
use nalgebra::UnitQuaternion;

/// The IMU on the body, as far as it stays the same from day to day.
#[derive(Debug, Clone, Copy, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Imu {
    /// Roll, pitch and yaw of the sensor's axes in the body frame.
    pub mounting_deg: [f64; 3],
    /// True rate over the rate that the gyroscope reports.
    pub gyro_scale: f64,
}

impl Default for Imu {
    /// Axes parallel to the body's, and a true scale.
    fn default() -> Self {
        Self {
            mounting_deg: [0.0; 3],
            gyro_scale: 1.0,
        }
    }
}

impl Imu {
    /// The orientation of the sensor on a body that moves like this, as a gyroscope of true scale
    /// has it. Where yaw has its zero is arbitrary: it stays that of the body.
    pub fn on(&self, body: &OrientationSeries) -> OrientationSeries {
        if self.mounting_deg == [0.0; 3] {
            return body.clone();
        }
        let [roll_rad, pitch_rad, yaw_rad] = self.mounting_deg.map(f64::to_radians);
        let mount = UnitQuaternion::from_euler_angles(roll_rad, pitch_rad, yaw_rad);
        let body_rad = body.angles_rad();
        let mut sensor_rad = body_rad.clone();
        for k in 0..body.times_s().len() {
            let (roll, pitch, yaw) = (body_rad.roll[k], body_rad.pitch[k], body_rad.yaw[k]);
            let sensor = UnitQuaternion::from_euler_angles(roll, pitch, yaw) * mount;
            let (roll, pitch, sensor_yaw) = sensor.euler_angles();
            let turned = sensor_yaw - yaw_rad - yaw;
            sensor_rad.roll[k] = roll;
            sensor_rad.pitch[k] = pitch;
            // Full turns of the body are kept.
            sensor_rad.yaw[k] = yaw + turned.sin().atan2(turned.cos());
        }
        OrientationSeries::new(body.times_s().to_vec(), sensor_rad).unwrap_or_else(|_| body.clone())
    }
}

#[cfg(test)]
mod tests {
    use mlr_filter::Axes;

    use super::*;

    #[test]
    fn a_mounted_sensor_is_tilted_as_the_body_turns() {
        let body = Axes {
            roll: vec![0.1, 0.0],
            pitch: vec![0.0, 0.2],
            yaw: vec![0.0, 7.0],
        };
        let body = OrientationSeries::new(vec![0.0, 1.0], body).unwrap();
        assert_eq!(Imu::default().on(&body), body);
        let mounting_deg = [1.0, 0.0, 0.0];
        let rolled = Imu {
            mounting_deg,
            ..Imu::default()
        }
        .on(&body);
        let added = |k: usize| rolled.angles_rad().roll[k] - body.angles_rad().roll[k];
        assert!((added(0).to_degrees() - 1.0).abs() < 1e-9);
        assert!((rolled.angles_rad().yaw[1] - 7.0).abs() < 0.01);
        // A sensor turned by a quarter takes pitch for roll, and yaw keeps its zero.
        let mounting_deg = [0.0, 0.0, 90.0];
        let turned = Imu {
            mounting_deg,
            ..Imu::default()
        }
        .on(&body);
        assert!((turned.angles_rad().pitch[0] + 0.1).abs() < 1e-9);
        assert!((turned.angles_rad().roll[1] - 0.2).abs() < 1e-9);
        assert!(turned.angles_rad().yaw[0].abs() < 1e-9);
    }
}
