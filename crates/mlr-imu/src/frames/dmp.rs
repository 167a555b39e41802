//! FIFO packets of the MPU6050's motion processor (MotionApps 2.0 and 6.12).
//!
//! Both begin with the quaternion w, x, y, z as big-endian i32 / 2³⁰. The gyroscope
//! runs at ±2000 °/s.

use crate::{
    GyroscopeRange, ImuSample,
    sample::{acceleration_mps2, angular_rate_radps, unit_quaternion},
};

/// Bytes of a MotionApps 2.0 packet.
pub(super) const LENGTH_20: usize = 42;
/// Bytes of a MotionApps 6.12 packet.
pub(super) const LENGTH_612: usize = 28;

const ONE: f64 = (1_u32 << 30) as f64;

/// MotionApps 2.0: rates at 16, 20, 24 and accelerations (8192 counts per g) at
/// 28, 32, 36, each in the upper half of a big-endian i32. `None` when the
/// quaternion is none.
pub(super) fn parse_20(bytes: &[u8; LENGTH_20]) -> Option<ImuSample> {
    parse(bytes, [16, 20, 24], [28, 32, 36], 8192.0)
}

/// MotionApps 6.12: accelerations (16384 counts per g) at 16, 18, 20 and rates at
/// 22, 24, 26 as big-endian i16. `None` when the quaternion is none.
pub(super) fn parse_612(bytes: &[u8; LENGTH_612]) -> Option<ImuSample> {
    parse(bytes, [22, 24, 26], [16, 18, 20], 16384.0)
}

fn parse(
    bytes: &[u8],
    rate_at: [usize; 3],
    acceleration_at: [usize; 3],
    counts_per_g: f64,
) -> Option<ImuSample> {
    let word = |at: usize| i16::from_be_bytes([bytes[at], bytes[at + 1]]);
    let component = |at: usize| {
        let long = i32::from_be_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
        f64::from(long) / ONE
    };
    let orientation = unit_quaternion([0, 4, 8, 12].map(component))?;
    Some(ImuSample {
        orientation: Some(orientation),
        angular_rate_radps: Some(angular_rate_radps(
            rate_at.map(word),
            GyroscopeRange::Dps2000.counts_per_dps(),
        )),
        acceleration_mps2: Some(acceleration_mps2(acceleration_at.map(word), counts_per_g)),
        ..Default::default()
    })
}
