#![no_main]

use libfuzzer_sys::fuzz_target;
use mlr_fuzz::{FRAMES, check_recovery, decode, decode_checked, scan};
use mlr_imu::frames::{Teapot, encode_teapot};
use nalgebra::{Quaternion, UnitQuaternion};

const LENGTH: usize = 14;
const HEADER: [u8; 2] = [0x24, 0x02];
/// What rounding to 1/16384 does to an angle, with a margin.
const ROUNDING_RAD: f64 = 3e-4;

fuzz_target!(|bytes: &[u8]| {
    let decoded = decode_checked(Teapot::default, bytes);
    assert_eq!(decoded.samples.len() as u64, decoded.counts.good);
    assert_eq!(decoded.counts.skipped, 0);
    let scanned = scan::<Teapot>(bytes, LENGTH);
    assert_eq!(decoded.samples, scanned.samples);
    assert_eq!(decoded.counts.bad, scanned.counts.bad);

    let orientations = orientations(bytes);
    let frames = frames(&orientations);
    let quiet = decode(Teapot::default(), &frames.concat());
    assert_eq!(quiet.samples.len(), FRAMES);
    assert_eq!((quiet.counts.bad, quiet.counts.lost), (0, 0));
    for (sample, sent) in quiet.samples.iter().zip(&orientations) {
        let apart_rad = sample.orientation.unwrap().angle_to(sent);
        assert!(apart_rad < ROUNDING_RAD, "{apart_rad}");
    }

    // A header within a frame may begin a false one, which no decoder without
    // foresight can tell from a true one.
    let unambiguous: Vec<Vec<u8>> = (0..)
        .zip(frames)
        .map(
            |(counter, frame)| match frame[1..].windows(2).any(|pair| pair == HEADER) {
                true => encode_teapot(&UnitQuaternion::identity(), counter).to_vec(),
                false => frame,
            },
        )
        .collect();
    check_recovery(Teapot::default, bytes, &unambiguous, 1);
});

/// Orientations made of the bytes, eight each.
fn orientations(bytes: &[u8]) -> Vec<UnitQuaternion<f64>> {
    let word = |chunk: &[u8], at: usize| f64::from(i16::from_be_bytes([chunk[at], chunk[at + 1]]));
    bytes
        .chunks_exact(8)
        .map(|c| Quaternion::new(word(c, 0), word(c, 2), word(c, 4), word(c, 6)))
        .map(|q| UnitQuaternion::try_new(q, 0.5).unwrap_or_default())
        .chain(std::iter::repeat(UnitQuaternion::identity()))
        .take(FRAMES)
        .collect()
}

fn frames(orientations: &[UnitQuaternion<f64>]) -> Vec<Vec<u8>> {
    (0..)
        .zip(orientations)
        .map(|(counter, orientation)| encode_teapot(orientation, counter).to_vec())
        .collect()
}
