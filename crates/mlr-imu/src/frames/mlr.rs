//! The framing of a bridge between an MPU6050 and a UART, made for 1 kHz with
//! device time.
//!
//! On the wire: the payload, COBS-coded, and the delimiter `00`. The payload:
//!
//! | byte | content |
//! |--:|:--|
//! | 0 | kind: 1 register burst, 2 DMP packet of 42 bytes, 3 DMP packet of 28 bytes |
//! | 1 | sequence counter, one up per frame |
//! | 2 to 5 | device time in µs, little-endian u32 |
//! | 6 to n - 3 | the bytes as read from the chip |
//! | n - 2, n - 1 | CRC-16/IBM-3740 over all before it, little-endian |
//!
//! The bridge reads registers 0x3B to 0x48 in one burst (kind 1), after setting
//! on the chip: `PWR_MGMT_1` (0x6B) to 1, clock from the gyroscope; `CONFIG`
//! (0x1A) to 3, low pass of 44 Hz, which makes the internal rate 1 kHz;
//! `SMPLRT_DIV` (0x19) to 0; `GYRO_CONFIG` (0x1B) and `ACCEL_CONFIG` (0x1C) to the
//! full scale that the reader is told; `INT_ENABLE` (0x38) to 1, so that each
//! burst follows a data-ready interrupt.

use crc::{CRC_16_IBM_3740, Crc};

use super::{Counts, Decode, dmp, register_burst};
use crate::{FullScale, ImuSample};

const CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);
const DELIMITER: u8 = 0;
const HEADER: usize = 6;
const CRC_LENGTH: usize = 2;
/// The longest payload, coded: COBS adds one byte to less than 254.
const LONGEST_CODED: usize = HEADER + dmp::LENGTH_20 + CRC_LENGTH + 1;

/// Decoder of the `mlr` framing.
///
/// Between two delimiters it only collects; what is longer than any frame is
/// counted as bad and thrown away up to the next delimiter.
#[derive(Debug, Clone, Default)]
pub struct Mlr {
    scale: FullScale,
    coded: Vec<u8>,
    too_long: bool,
    counts: Counts,
    last_counter: Option<u8>,
}

/// The bytes that a bridge read from the chip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MlrPayload {
    /// Registers 0x3B to 0x48.
    RegisterBurst([u8; register_burst::LENGTH]),
    /// A packet of MotionApps 2.0.
    Dmp42([u8; dmp::LENGTH_20]),
    /// A packet of MotionApps 6.12.
    Dmp28([u8; dmp::LENGTH_612]),
}

impl Mlr {
    /// A decoder for a chip with this full scale. It concerns register bursts
    /// only; the motion processor has its own.
    pub fn new(scale: FullScale) -> Self {
        Self {
            scale,
            ..Default::default()
        }
    }

    /// Counter and sample of a coded frame, if it is valid.
    fn parse(&self) -> Option<(u8, ImuSample)> {
        let payload = cobs::decode_vec(&self.coded).ok()?;
        let (content, crc) = payload.split_last_chunk::<CRC_LENGTH>()?;
        if CRC.checksum(content) != u16::from_le_bytes(*crc) {
            return None;
        }
        let (&[kind, counter, t0, t1, t2, t3], chip) = content.split_first_chunk::<HEADER>()?;
        let sample = match kind {
            1 => register_burst::parse(chip.try_into().ok()?, self.scale),
            2 => dmp::parse_20(chip.try_into().ok()?)?,
            3 => dmp::parse_612(chip.try_into().ok()?)?,
            _ => return None,
        };
        let device_time_us = Some(u32::from_le_bytes([t0, t1, t2, t3]));
        Some((
            counter,
            ImuSample {
                device_time_us,
                ..sample
            },
        ))
    }
}

impl Decode for Mlr {
    fn push(&mut self, byte: u8, samples: &mut Vec<ImuSample>) {
        if byte != DELIMITER {
            if self.coded.len() < LONGEST_CODED {
                self.coded.push(byte);
            } else {
                self.too_long = true;
            }
            return;
        }
        if !self.coded.is_empty() {
            match self.parse().filter(|_| !self.too_long) {
                Some((counter, sample)) => {
                    self.counts
                        .good_in_sequence(counter, &mut self.last_counter);
                    samples.push(sample);
                }
                None => self.counts.bad += 1,
            }
        }
        self.coded.clear();
        self.too_long = false;
    }

    fn counts(&self) -> Counts {
        self.counts
    }
}

/// The bytes on the wire, delimiter included.
pub fn encode_mlr(payload: &MlrPayload, counter: u8, device_time_us: u32) -> Vec<u8> {
    let (kind, chip): (u8, &[u8]) = match payload {
        MlrPayload::RegisterBurst(bytes) => (1, bytes),
        MlrPayload::Dmp42(bytes) => (2, bytes),
        MlrPayload::Dmp28(bytes) => (3, bytes),
    };
    let mut content = vec![kind, counter];
    content.extend(device_time_us.to_le_bytes());
    content.extend(chip);
    let crc = CRC.checksum(&content);
    content.extend(crc.to_le_bytes());
    let mut wire = cobs::encode_vec(&content);
    wire.push(DELIMITER);
    wire
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::STANDARD_GRAVITY_MPS2;

    fn decode(bytes: &[u8]) -> (Vec<ImuSample>, Counts) {
        let mut decoder = Mlr::default();
        let mut samples = Vec::new();
        decoder.extend(bytes, &mut samples);
        (samples, decoder.counts())
    }

    fn bursts(n: u8) -> Vec<Vec<u8>> {
        (0..n)
            .map(|i| {
                let burst = MlrPayload::RegisterBurst([i; register_burst::LENGTH]);
                encode_mlr(&burst, i, u32::from(i) * 1000)
            })
            .collect()
    }

    /// The quaternion (w, x, y, z) = (0.6, 0, 0.8, 0).
    fn dmp_packet<const N: usize>() -> [u8; N] {
        let mut packet = [0; N];
        let long = |x: f64| ((x * f64::from(1 << 30)) as i32).to_be_bytes();
        packet[0..4].copy_from_slice(&long(0.6));
        packet[8..12].copy_from_slice(&long(0.8));
        packet
    }

    #[test]
    fn the_crc_is_the_one_with_this_check_value() {
        assert_eq!(CRC.checksum(b"123456789"), 0x29b1);
    }

    #[test]
    fn motion_processor_packets_of_both_kinds() {
        let mut long = dmp_packet::<42>();
        long[16..18].copy_from_slice(&164_i16.to_be_bytes());
        long[36..38].copy_from_slice(&8192_i16.to_be_bytes());
        let mut short = dmp_packet::<28>();
        short[22..24].copy_from_slice(&164_i16.to_be_bytes());
        short[20..22].copy_from_slice(&16384_i16.to_be_bytes());
        for payload in [MlrPayload::Dmp42(long), MlrPayload::Dmp28(short)] {
            let (samples, counts) = decode(&encode_mlr(&payload, 0, 123_456));
            assert_eq!(counts.good, 1);
            let sample = samples[0];
            assert_eq!(sample.device_time_us, Some(123_456));
            let q = sample.orientation.unwrap();
            assert!((q.w - 0.6).abs() < 1e-8 && (q.j - 0.8).abs() < 1e-8);
            let rate_dps = sample.angular_rate_radps.unwrap().x.to_degrees();
            assert!((rate_dps - 10.0).abs() < 1e-9);
            let up = sample.acceleration_mps2.unwrap().z;
            assert!((up - STANDARD_GRAVITY_MPS2).abs() < 1e-9);
        }
    }

    #[test]
    fn unknown_kinds_and_wrong_lengths_are_bad() {
        let mut content = vec![9, 0, 0, 0, 0, 0];
        content.extend([0; 14]);
        for kind in [9, 2] {
            content[0] = kind;
            let mut framed = content.clone();
            framed.extend(CRC.checksum(&content).to_le_bytes());
            let mut wire = cobs::encode_vec(&framed);
            wire.push(0);
            let (samples, counts) = decode(&wire);
            assert!(samples.is_empty());
            assert_eq!(counts.bad, 1);
        }
    }

    #[test]
    fn memory_stays_small_without_delimiters() {
        let mut decoder = Mlr::default();
        let mut samples = Vec::new();
        decoder.extend(&[1; 100_000], &mut samples);
        assert!(decoder.coded.capacity() < 200);
        decoder.extend(&[0], &mut samples);
        decoder.extend(&bursts(1)[0], &mut samples);
        assert_eq!((samples.len(), decoder.counts().bad), (1, 1));
    }

    proptest! {
        #[test]
        fn what_is_encoded_is_decoded(chip in any::<[u8; 14]>(), counter: u8, time: u32) {
            let wire = encode_mlr(&MlrPayload::RegisterBurst(chip), counter, time);
            prop_assert!(!wire[..wire.len() - 1].contains(&0));
            let (samples, _) = decode(&wire);
            let expected = ImuSample {
                device_time_us: Some(time),
                ..register_burst::parse(&chip, FullScale::default())
            };
            prop_assert_eq!(samples, vec![expected]);
        }

        #[test]
        fn a_corrupt_byte_costs_at_most_two_frames(at in 24_usize..180, flip in 1..=255_u8) {
            let mut bytes = bursts(10).concat();
            bytes[at] ^= flip;
            let (samples, counts) = decode(&bytes);
            prop_assert!(samples.len() >= 8);
            prop_assert_eq!(counts.good + counts.lost, 10);
        }

        #[test]
        fn frames_in_noise_without_sync_bytes_are_all_found(
            gaps in prop::collection::vec(prop::collection::vec(1..=0xff_u8, 0..90), 6),
        ) {
            // The delimiter is the sync byte: it ends the noise before a frame.
            let mut bytes = Vec::new();
            for (frame, noise) in bursts(6).iter().zip(&gaps) {
                bytes.extend(noise);
                bytes.push(0);
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
