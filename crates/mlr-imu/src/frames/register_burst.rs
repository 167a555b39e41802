//! Registers 0x3B to 0x48 of the MPU6050, read in one burst of 14 bytes.

use crate::{
    FullScale, ImuSample,
    sample::{acceleration_mps2, angular_rate_radps},
};

/// Bytes of the burst.
pub(super) const LENGTH: usize = 14;

/// Big-endian i16: acceleration x, y, z, temperature, rate x, y, z. Temperature
/// in °C is counts / 340 + 36.53 (register map, 4.18).
pub(super) fn parse(bytes: &[u8; LENGTH], scale: FullScale) -> ImuSample {
    let word = |at: usize| i16::from_be_bytes([bytes[at], bytes[at + 1]]);
    let vector = |at: usize| [word(at), word(at + 2), word(at + 4)];
    ImuSample {
        acceleration_mps2: Some(acceleration_mps2(
            vector(0),
            scale.accelerometer.counts_per_g(),
        )),
        angular_rate_radps: Some(angular_rate_radps(
            vector(8),
            scale.gyroscope.counts_per_dps(),
        )),
        temperature_c: Some(f64::from(word(6)) / 340.0 + 36.53),
        ..Default::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::STANDARD_GRAVITY_MPS2;

    fn check(bytes: [u8; 14], a_g: [f64; 3], temperature_c: f64, g_dps: [f64; 3]) {
        let sample = parse(&bytes, FullScale::default());
        let ours = sample.acceleration_mps2.unwrap() / STANDARD_GRAVITY_MPS2;
        for (a, b) in ours.iter().zip(a_g) {
            assert!((a - b).abs() < 5e-5, "{ours:?}");
        }
        assert!((sample.temperature_c.unwrap() - temperature_c).abs() < 5e-4);
        let ours = sample.angular_rate_radps.unwrap().map(f64::to_degrees);
        for (a, b) in ours.iter().zip(g_dps) {
            assert!((a - b).abs() < 5e-4, "{ours:?}");
        }
    }

    #[test]
    fn real_counts() {
        check(
            [
                0x06, 0xf0, 0x02, 0xa4, 0x45, 0x84, 0xfd, 0x00, 0xff, 0xd2, 0x00, 0x2a, 0xfd, 0xf3,
            ],
            [0.1084, 0.0413, 1.0862],
            34.271,
            [-0.351, 0.321, -4.008],
        );
        check(
            [
                0xf1, 0xc4, 0x07, 0xac, 0x44, 0xe0, 0xfc, 0xe0, 0x02, 0xc5, 0x2e, 0xc6, 0x06, 0x82,
            ],
            [-0.2224, 0.1199, 1.0762],
            34.177,
            [5.412, 91.405, 12.718],
        );
    }
}
