#![no_main]

use libfuzzer_sys::fuzz_target;
use mlr_fuzz::{FRAMES, check_recovery, decode, decode_checked, scan};
use mlr_imu::{
    ImuSample, STANDARD_GRAVITY_MPS2,
    frames::{Witmotion, WitmotionFrame, encode_witmotion},
};
use nalgebra::Vector3;

const LENGTH: usize = 11;
const HEADER: u8 = 0x55;
const ANGLE: WitmotionFrame = WitmotionFrame::Angle(Vector3::new(0.1, 0.2, 0.3));

fuzz_target!(|bytes: &[u8]| {
    let decoded = decode_checked(Witmotion::default, bytes);
    assert_eq!(decoded.counts.lost, 0);
    // Acceleration and rate may still be waiting for their angle.
    let waiting = decoded.counts.good - said(&decoded.samples);
    assert!(waiting <= 2, "{waiting}");
    assert_eq!(
        decoded.counts,
        scan::<Witmotion>(bytes, LENGTH).counts,
        "a scan finds other frames"
    );

    let frames = frames(bytes);
    let quiet = decode(Witmotion::default(), &frames.concat());
    assert_eq!(quiet.counts.good, FRAMES as u64);
    assert_eq!(said(&quiet.samples), FRAMES as u64);
    assert_eq!((quiet.counts.bad, quiet.counts.skipped), (0, 0));

    // A header within a frame may begin a false one, which no decoder without
    // foresight can tell from a true one.
    let unambiguous: Vec<Vec<u8>> = frames
        .into_iter()
        .map(|frame| match frame[1..].contains(&HEADER) {
            true => encode_witmotion(&ANGLE).to_vec(),
            false => frame,
        })
        .collect();
    check_recovery(Witmotion::default, bytes, &unambiguous, 1);
});

/// How many frames the samples were put together from.
fn said(samples: &[ImuSample]) -> u64 {
    samples
        .iter()
        .map(|sample| {
            let count = u64::from(sample.acceleration_mps2.is_some())
                + u64::from(sample.angular_rate_radps.is_some())
                + u64::from(sample.orientation.is_some());
            assert!(count > 0, "an empty sample");
            count
        })
        .sum()
}

/// Two angles, which complete whatever was begun before, frames made of the
/// bytes, seven each, and a last angle.
fn frames(bytes: &[u8]) -> Vec<Vec<u8>> {
    let made = bytes.chunks_exact(7).map(|chunk| {
        let share = |at: usize| f64::from(i16::from_le_bytes([chunk[at], chunk[at + 1]])) / 32768.0;
        let shares = Vector3::new(share(1), share(3), share(5));
        match chunk[0] % 3 {
            0 => WitmotionFrame::Acceleration(shares * 16.0 * STANDARD_GRAVITY_MPS2),
            1 => WitmotionFrame::Rate(shares * 2000_f64.to_radians()),
            _ => WitmotionFrame::Angle(shares * std::f64::consts::PI),
        }
    });
    [ANGLE; 2]
        .into_iter()
        .chain(made.take(FRAMES - 3))
        .chain(std::iter::repeat(ANGLE))
        .take(FRAMES)
        .map(|frame| encode_witmotion(&frame).to_vec())
        .collect()
}
