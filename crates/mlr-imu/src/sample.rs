//! What one frame of an IMU says, in SI units.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// Standard gravity, m/s² per g.
pub const STANDARD_GRAVITY_MPS2: f64 = 9.806_65;

/// One moment of an IMU, as far as its frame tells. Units and signs follow
/// REP-145: the sensor's own axes, the specific force at rest pointing up.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ImuSample {
    /// The device's clock, where the frame carries it. It wraps after 2³² µs.
    pub device_time_us: Option<u32>,
    /// Specific force in m/s²: +9.81 along the axis that points up at rest.
    pub acceleration_mps2: Option<Vector3<f64>>,
    /// Angular rate in rad/s, right-handed about each axis.
    pub angular_rate_radps: Option<Vector3<f64>>,
    /// Orientation of the sensor in a frame whose z axis points up, where the
    /// device fuses it.
    pub orientation: Option<UnitQuaternion<f64>>,
    /// Temperature of the die.
    pub temperature_c: Option<f64>,
}

/// Full-scale ranges of an MPU6050, which set the meaning of its counts (data
/// sheet, registers 27 and 28).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct FullScale {
    /// Range of the accelerometer.
    pub accelerometer: AccelerometerRange,
    /// Range of the gyroscope.
    pub gyroscope: GyroscopeRange,
}

/// Range of the accelerometer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum AccelerometerRange {
    /// ±2 g, 16384 counts per g.
    #[default]
    G2,
    /// ±4 g, 8192 counts per g.
    G4,
    /// ±8 g, 4096 counts per g.
    G8,
    /// ±16 g, 2048 counts per g.
    G16,
}

/// Range of the gyroscope.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum GyroscopeRange {
    /// ±250 °/s, 131 counts per °/s.
    #[default]
    Dps250,
    /// ±500 °/s, 65.5 counts per °/s.
    Dps500,
    /// ±1000 °/s, 32.8 counts per °/s.
    Dps1000,
    /// ±2000 °/s, 16.4 counts per °/s.
    Dps2000,
}

impl AccelerometerRange {
    /// Counts per g.
    pub fn counts_per_g(self) -> f64 {
        match self {
            Self::G2 => 16384.0,
            Self::G4 => 8192.0,
            Self::G8 => 4096.0,
            Self::G16 => 2048.0,
        }
    }
}

impl GyroscopeRange {
    /// Counts per degree per second.
    pub fn counts_per_dps(self) -> f64 {
        match self {
            Self::Dps250 => 131.0,
            Self::Dps500 => 65.5,
            Self::Dps1000 => 32.8,
            Self::Dps2000 => 16.4,
        }
    }
}

/// Specific force from accelerometer counts.
pub(crate) fn acceleration_mps2(counts: [i16; 3], counts_per_g: f64) -> Vector3<f64> {
    Vector3::from(counts.map(f64::from)) * (STANDARD_GRAVITY_MPS2 / counts_per_g)
}

/// Angular rate from gyroscope counts.
pub(crate) fn angular_rate_radps(counts: [i16; 3], counts_per_dps: f64) -> Vector3<f64> {
    Vector3::from(counts.map(f64::from)) * (1.0_f64.to_radians() / counts_per_dps)
}

/// The quaternion w, x, y, z, if its norm is within 2 % of one.
pub(crate) fn unit_quaternion(wxyz: [f64; 4]) -> Option<UnitQuaternion<f64>> {
    const TOLERANCE: f64 = 0.02;
    let quaternion = Quaternion::new(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
    ((quaternion.norm() - 1.0).abs() <= TOLERANCE)
        .then(|| UnitQuaternion::from_quaternion(quaternion))
}
