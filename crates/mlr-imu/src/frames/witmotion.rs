//! The frames of WitMotion's JY61, WT61 and BWT61 modules.
//!
//! | byte | content |
//! |--:|:--|
//! | 0 | `55` |
//! | 1 | type: `51` acceleration / 32768 × 16 g, `52` rate / 32768 × 2000 °/s, `53` roll, pitch, yaw / 32768 × 180° |
//! | 2 to 9 | four little-endian i16; the fourth depends on the model |
//! | 10 | low 8 bits of the sum of bytes 0 to 9 |
//!
//! The module sends the three types in turn; an angle completes a sample.

use nalgebra::{UnitQuaternion, Vector3};

use super::{Counts, Decode, buffer::FrameBuffer};
use crate::{ImuSample, STANDARD_GRAVITY_MPS2};

const LENGTH: usize = 11;
const HEADER: u8 = 0x55;
const ACCELERATION: u8 = 0x51;
const RATE: u8 = 0x52;
const ANGLE: u8 = 0x53;
/// Every type that a module of this family may send.
const TYPES: std::ops::RangeInclusive<u8> = 0x50..=0x5f;
const FULL_SCALE: f64 = 32768.0;
const ACCELERATION_MPS2: f64 = 16.0 * STANDARD_GRAVITY_MPS2;
const RATE_DPS: f64 = 2000.0;
const ANGLE_DEG: f64 = 180.0;

/// Decoder of the `witmotion` framing.
#[derive(Debug, Clone, Default)]
pub struct Witmotion {
    buffer: FrameBuffer<LENGTH>,
    counts: Counts,
    pending: ImuSample,
}

/// One frame that says something about motion, in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum WitmotionFrame {
    /// Specific force in m/s².
    Acceleration(Vector3<f64>),
    /// Angular rate in rad/s.
    Rate(Vector3<f64>),
    /// Roll, pitch, yaw in radians, applied in the order yaw, pitch, roll.
    Angle(Vector3<f64>),
}

fn can_begin(bytes: &[u8]) -> bool {
    bytes[0] == HEADER && bytes.get(1).is_none_or(|kind| TYPES.contains(kind))
}

fn sum(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0, |sum, byte| sum.wrapping_add(*byte))
}

impl Witmotion {
    fn take(&mut self, frame: &[u8; LENGTH], samples: &mut Vec<ImuSample>) {
        let word = |at: usize| f64::from(i16::from_le_bytes([frame[at], frame[at + 1]]));
        let scaled = |full: f64| Vector3::new(word(2), word(4), word(6)) * (full / FULL_SCALE);
        match frame[1] {
            ACCELERATION => {
                self.emit_if(self.pending.acceleration_mps2.is_some(), samples);
                self.pending.acceleration_mps2 = Some(scaled(ACCELERATION_MPS2));
            }
            RATE => {
                self.emit_if(self.pending.angular_rate_radps.is_some(), samples);
                self.pending.angular_rate_radps = Some(scaled(RATE_DPS.to_radians()));
            }
            ANGLE => {
                let angle = scaled(ANGLE_DEG.to_radians());
                let orientation = UnitQuaternion::from_euler_angles(angle.x, angle.y, angle.z);
                self.pending.orientation = Some(orientation);
                self.emit_if(true, samples);
            }
            _ => {
                self.counts.skipped += 1;
                return;
            }
        }
        self.counts.good += 1;
    }

    fn emit_if(&mut self, complete: bool, samples: &mut Vec<ImuSample>) {
        if complete {
            samples.push(std::mem::take(&mut self.pending));
        }
    }
}

impl Decode for Witmotion {
    fn push(&mut self, byte: u8, samples: &mut Vec<ImuSample>) {
        let Some(frame) = self.buffer.push(byte, can_begin) else {
            return;
        };
        if sum(&frame[..LENGTH - 1]) == frame[LENGTH - 1] {
            self.buffer.accept();
            self.take(&frame, samples);
        } else {
            self.counts.bad += 1;
            self.buffer.reject(can_begin);
        }
    }

    fn counts(&self) -> Counts {
        self.counts
    }
}

/// The bytes of a frame. Values beyond the full scale are clipped to it; the
/// fourth word is zero.
pub fn encode_witmotion(frame: &WitmotionFrame) -> [u8; LENGTH] {
    let (kind, values, full) = match frame {
        WitmotionFrame::Acceleration(a) => (ACCELERATION, a, ACCELERATION_MPS2),
        WitmotionFrame::Rate(rate) => (RATE, rate, RATE_DPS.to_radians()),
        WitmotionFrame::Angle(angle) => (ANGLE, angle, ANGLE_DEG.to_radians()),
    };
    let mut bytes = [0; LENGTH];
    bytes[0] = HEADER;
    bytes[1] = kind;
    for (slot, value) in bytes[2..8].chunks_exact_mut(2).zip(values.iter()) {
        slot.copy_from_slice(&((value / full * FULL_SCALE).round() as i16).to_le_bytes());
    }
    bytes[LENGTH - 1] = sum(&bytes[..LENGTH - 1]);
    bytes
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn decode(bytes: &[u8]) -> (Vec<ImuSample>, Counts) {
        let mut decoder = Witmotion::default();
        let mut samples = Vec::new();
        decoder.extend(bytes, &mut samples);
        (samples, decoder.counts())
    }

    fn close(ours: Vector3<f64>, expected: [f64; 3], tolerance: f64) {
        for (a, b) in ours.iter().zip(expected) {
            assert!((a - b).abs() < tolerance, "{ours:?} is not {expected:?}");
        }
    }

    #[test]
    fn real_frames_of_a_module() {
        let bytes: [u8; 33] = [
            0x55, 0x51, 0x03, 0x00, 0x0b, 0x00, 0x4d, 0x08, 0xde, 0x09, 0xf0, //
            0x55, 0x52, 0xf5, 0xff, 0xea, 0xff, 0x15, 0x00, 0xde, 0x09, 0x80, //
            0x55, 0x53, 0x3a, 0x00, 0xdf, 0xff, 0x1c, 0x00, 0x58, 0x2d, 0x61,
        ];
        let (samples, counts) = decode(&bytes);
        assert_eq!((samples.len(), counts.good, counts.bad), (1, 3, 0));
        let sample = samples[0];
        let acceleration_g = sample.acceleration_mps2.unwrap() / STANDARD_GRAVITY_MPS2;
        close(acceleration_g, [0.00146, 0.00537, 1.03760], 5e-6);
        let rate_dps = sample.angular_rate_radps.unwrap().map(f64::to_degrees);
        close(rate_dps, [-0.67139, -1.34277, 1.28174], 5e-6);
        let (roll, pitch, yaw) = sample.orientation.unwrap().euler_angles();
        let angles_deg = Vector3::new(roll, pitch, yaw).map(f64::to_degrees);
        close(angles_deg, [0.31860, -0.18127, 0.15381], 5e-6);
    }

    #[test]
    fn real_frames_of_a_module_that_is_turned() {
        let bytes = [
            0x55, 0x52, 0xa3, 0xff, 0x06, 0xf2, 0x7f, 0xff, 0x12, 0x0b, 0xdc, //
            0x55, 0x53, 0x6e, 0x86, 0xc1, 0x1d, 0x00, 0xf8, 0x58, 0x2d, 0xf7,
        ];
        let (samples, _) = decode(&bytes);
        let rate_dps = samples[0].angular_rate_radps.unwrap().map(f64::to_degrees);
        close(rate_dps, [-5.67627, -218.38379, -7.87354], 5e-6);
        let (roll, pitch, yaw) = samples[0].orientation.unwrap().euler_angles();
        let angles_deg = Vector3::new(roll, pitch, yaw).map(f64::to_degrees);
        close(angles_deg, [-170.95825, 41.84143, -11.25], 1e-5);
    }

    #[test]
    fn other_types_are_valid_and_skipped() {
        let mut time = [0x55, 0x50, 1, 2, 3, 4, 5, 6, 7, 8, 0];
        time[10] = sum(&time[..10]);
        let (samples, counts) = decode(&time);
        assert!(samples.is_empty());
        assert_eq!((counts.good, counts.skipped, counts.bad), (0, 1, 0));
    }

    #[test]
    fn a_missing_angle_does_not_mix_two_samples() {
        let acceleration = |x| encode_witmotion(&WitmotionFrame::Acceleration(Vector3::x() * x));
        let rate = encode_witmotion(&WitmotionFrame::Rate(Vector3::y()));
        let bytes = [acceleration(1.0), rate, acceleration(2.0)].concat();
        let (samples, _) = decode(&bytes);
        assert_eq!(samples.len(), 1);
        assert!((samples[0].acceleration_mps2.unwrap().x - 1.0).abs() < 0.005);
        assert!(samples[0].orientation.is_none());
    }

    proptest! {
        #[test]
        fn what_is_encoded_is_decoded(angle in prop::array::uniform3(-1.5..1.5_f64)) {
            let frame = encode_witmotion(&WitmotionFrame::Angle(Vector3::from(angle)));
            let (roll, pitch, yaw) = decode(&frame).0[0].orientation.unwrap().euler_angles();
            for (got, sent) in [roll, pitch, yaw].iter().zip(angle) {
                prop_assert!((got - sent).abs() < 1e-4);
            }
        }

        #[test]
        fn a_corrupt_byte_costs_at_most_two_frames(at in 11_usize..77, flip in 1..=255_u8) {
            let frame = encode_witmotion(&WitmotionFrame::Angle(Vector3::new(0.1, 0.2, 0.3)));
            let mut bytes = frame.repeat(8);
            bytes[at] ^= flip;
            let (samples, _) = decode(&bytes);
            prop_assert!(samples.len() >= 6, "{}", samples.len());
        }

        #[test]
        fn frames_in_noise_without_sync_bytes_are_all_found(
            gaps in prop::collection::vec(prop::collection::vec(0x56..=0xff_u8, 0..30), 6),
        ) {
            let frame = encode_witmotion(&WitmotionFrame::Angle(Vector3::new(0.1, 0.2, 0.3)));
            let bytes: Vec<u8> = gaps.iter().flat_map(|gap| [gap.as_slice(), &frame].concat()).collect();
            prop_assert_eq!(decode(&bytes).0.len(), 6);
        }

        #[test]
        fn any_bytes_are_survived(bytes in prop::collection::vec(any::<u8>(), 0..500)) {
            decode(&bytes);
        }
    }
}
