#![no_main]

use crc::{CRC_16_IBM_3740, Crc};
use libfuzzer_sys::fuzz_target;
use mlr_fuzz::{Decoded, FRAMES, check_recovery, decode, decode_checked, pieces};
use mlr_imu::frames::{Mlr, MlrPayload, encode_mlr};

const DELIMITER: u8 = 0;
/// How far from one the norm of a quaternion may be.
const NORM_TOLERANCE: f64 = 0.02;
static CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);

fuzz_target!(|bytes: &[u8]| {
    let Decoded { samples, counts } = decode_checked(Mlr::default, bytes);
    assert_eq!(samples.len() as u64, counts.good);
    assert_eq!(counts.skipped, 0);
    assert!(samples.iter().all(|sample| sample.device_time_us.is_some()));
    let ended = bytes
        .split_inclusive(|byte| *byte == DELIMITER)
        .filter(|frame| frame.len() > 1 && frame.ends_with(&[DELIMITER]))
        .count();
    assert_eq!(counts.good + counts.bad, ended as u64);

    pieces(bytes).for_each(check_sealed);

    let frames = frames(bytes);
    let quiet = decode(Mlr::default(), &frames.concat());
    assert_eq!(quiet.counts.good, FRAMES as u64);
    assert_eq!((quiet.counts.bad, quiet.counts.lost), (0, 0));
    check_recovery(Mlr::default, bytes, &frames, 1);
    check_recovery(Mlr::default, &[bytes, &[DELIMITER]].concat(), &frames, 0);
});

/// A frame with this content and a right checksum is good if its kind and length
/// are. The kind is the high two bits of the first byte.
fn check_sealed(piece: &[u8]) {
    let mut content = piece.to_vec();
    content[0] >>= 6;
    let kind = content[0];
    let Decoded { samples, counts } = decode_checked(Mlr::default, &sealed(content));
    assert_eq!(counts.good + counts.bad, 1);
    match (kind, piece.len()) {
        (1, 20) => assert!(samples[0].acceleration_mps2.is_some()),
        (2, 48) | (3, 34) => {
            assert!(samples.iter().all(|sample| sample.orientation.is_some()));
            let from_one = (quaternion_norm(piece) - 1.0).abs();
            assert!(counts.good == 1 || from_one > 0.99 * NORM_TOLERANCE);
            assert!(counts.bad == 1 || from_one < 1.01 * NORM_TOLERANCE);
        }
        _ => assert!(samples.is_empty()),
    }
    for sample in samples {
        let time_us = u32::from_le_bytes([piece[2], piece[3], piece[4], piece[5]]);
        assert_eq!(sample.device_time_us, Some(time_us));
    }
}

/// Of the motion processor's packet behind the header.
fn quaternion_norm(content: &[u8]) -> f64 {
    let (longs, _) = content[6..22].as_chunks::<4>();
    let squares = longs
        .iter()
        .map(|long| (f64::from(i32::from_be_bytes(*long)) / f64::from(1 << 30)).powi(2));
    squares.sum::<f64>().sqrt()
}

fn sealed(mut content: Vec<u8>) -> Vec<u8> {
    content.extend(CRC.checksum(&content).to_le_bytes());
    let mut wire = cobs::encode_vec(&content);
    wire.push(DELIMITER);
    wire
}

/// Register bursts made of the bytes, fourteen each.
fn frames(bytes: &[u8]) -> Vec<Vec<u8>> {
    let bursts = bytes
        .as_chunks::<14>()
        .0
        .iter()
        .chain(std::iter::repeat(&[0; 14]))
        .take(FRAMES);
    (0..)
        .zip(bursts)
        .map(|(counter, burst)| {
            let payload = MlrPayload::RegisterBurst(*burst);
            encode_mlr(&payload, counter, u32::from(counter) * 1000)
        })
        .collect()
}
