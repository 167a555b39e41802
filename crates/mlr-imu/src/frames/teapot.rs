//! The packet of i2cdevlib's `MPU6050_DMP6` sketch, made for its teapot demo.
//!
//! | byte | content |
//! |--:|:--|
//! | 0, 1 | `24 02` |
//! | 2 to 9 | quaternion w, x, y, z, big-endian i16 / 16384 |
//! | 10 | `00` |
//! | 11 | counter |
//! | 12, 13 | `0D 0A` |

use nalgebra::UnitQuaternion;

use super::{Counts, Decode, buffer::FrameBuffer};
use crate::{ImuSample, sample::unit_quaternion};

const LENGTH: usize = 14;
const HEADER: [u8; 2] = [0x24, 0x02];
const TRAILER: [u8; 2] = [0x0d, 0x0a];
const ONE: f64 = 16384.0;

/// Decoder of the `teapot` framing.
#[derive(Debug, Clone, Default)]
pub struct Teapot {
    buffer: FrameBuffer<LENGTH>,
    counts: Counts,
    last_counter: Option<u8>,
}

fn can_begin(bytes: &[u8]) -> bool {
    bytes
        .iter()
        .zip(HEADER)
        .all(|(byte, expected)| *byte == expected)
}

fn parse(frame: &[u8; LENGTH]) -> Option<UnitQuaternion<f64>> {
    if frame[10] != 0 || frame[12..] != TRAILER {
        return None;
    }
    let component = |at: usize| f64::from(i16::from_be_bytes([frame[at], frame[at + 1]])) / ONE;
    unit_quaternion([component(2), component(4), component(6), component(8)])
}

impl Decode for Teapot {
    fn push(&mut self, byte: u8, samples: &mut Vec<ImuSample>) {
        let Some(frame) = self.buffer.push(byte, can_begin) else {
            return;
        };
        match parse(&frame) {
            Some(orientation) => {
                self.buffer.accept();
                self.counts
                    .good_in_sequence(frame[11], &mut self.last_counter);
                samples.push(ImuSample {
                    orientation: Some(orientation),
                    ..Default::default()
                });
            }
            None => {
                self.counts.bad += 1;
                self.buffer.reject(can_begin);
            }
        }
    }

    fn counts(&self) -> Counts {
        self.counts
    }
}

/// The frame of an orientation.
pub fn encode_teapot(orientation: &UnitQuaternion<f64>, counter: u8) -> [u8; LENGTH] {
    let mut frame = [0; LENGTH];
    frame[..2].copy_from_slice(&HEADER);
    let q = orientation.quaternion();
    for (slot, component) in frame[2..10].chunks_exact_mut(2).zip([q.w, q.i, q.j, q.k]) {
        slot.copy_from_slice(&((component * ONE).round() as i16).to_be_bytes());
    }
    frame[11] = counter;
    frame[12..].copy_from_slice(&TRAILER);
    frame
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn decode(bytes: &[u8]) -> (Vec<ImuSample>, Counts) {
        let mut decoder = Teapot::default();
        let mut samples = Vec::new();
        decoder.extend(bytes, &mut samples);
        (samples, decoder.counts())
    }

    fn frames(n: u8) -> Vec<[u8; LENGTH]> {
        (0..n)
            .map(|i| {
                let q = UnitQuaternion::from_euler_angles(f64::from(i) * 0.01, -0.1, 0.2);
                encode_teapot(&q, i)
            })
            .collect()
    }

    #[test]
    fn a_quaternion_that_is_none_is_rejected() {
        let mut frame = frames(1)[0];
        frame[2] = 0x7f;
        let (samples, counts) = decode(&frame);
        assert!(samples.is_empty());
        assert_eq!(counts.bad, 1);
    }

    #[test]
    fn missing_frames_are_counted() {
        let all = frames(10);
        let bytes: Vec<u8> = [&all[..3], &all[5..]].concat().concat();
        let (samples, counts) = decode(&bytes);
        assert_eq!((samples.len(), counts.good, counts.lost), (8, 8, 2));
    }

    #[test]
    fn the_counter_wraps() {
        let q = UnitQuaternion::identity();
        let bytes = [254, 255, 0, 1].map(|i| encode_teapot(&q, i)).concat();
        assert_eq!(decode(&bytes).1.lost, 0);
    }

    proptest! {
        #[test]
        fn what_is_encoded_is_decoded(angles in prop::array::uniform3(-3.0..3.0_f64)) {
            let q = UnitQuaternion::from_euler_angles(angles[0], angles[1], angles[2]);
            let (samples, _) = decode(&encode_teapot(&q, 7));
            let apart_rad = samples[0].orientation.unwrap().angle_to(&q);
            prop_assert!(apart_rad < 3e-4, "{apart_rad}");
        }

        #[test]
        fn a_corrupt_byte_costs_at_most_two_frames(at in 14_usize..70, flip in 1..=255_u8) {
            let mut bytes = frames(8).concat();
            bytes[at] ^= flip;
            let (samples, counts) = decode(&bytes);
            prop_assert!(samples.len() >= 6);
            prop_assert_eq!(counts.good as usize, samples.len());
        }

        #[test]
        fn frames_in_noise_without_sync_bytes_are_all_found(
            gaps in prop::collection::vec(prop::collection::vec(0x25..=0xff_u8, 0..30), 6),
        ) {
            let mut bytes = Vec::new();
            for (frame, noise) in frames(6).iter().zip(&gaps) {
                bytes.extend(noise);
                bytes.extend(frame);
            }
            prop_assert_eq!(decode(&bytes).0.len(), 6);
        }

        #[test]
        fn any_bytes_are_survived(bytes in prop::collection::vec(any::<u8>(), 0..500)) {
            decode(&bytes);
        }
    }
}
