#![no_main]

use libfuzzer_sys::fuzz_target;
use mlr_fuzz::{Decoded, FRAMES, decode, decode_checked};
use mlr_imu::{
    FullScale,
    frames::{
        Decode, Framing, Mlr, MlrPayload, Recognizer, Teapot, Witmotion, WitmotionFrame,
        encode_mlr, encode_teapot, encode_witmotion,
    },
};
use nalgebra::{UnitQuaternion, Vector3};

const FRAMINGS: [Framing; 3] = [Framing::Teapot, Framing::Witmotion, Framing::Mlr];
/// Good frames that decide.
const ENOUGH: u64 = 5;

fuzz_target!(|bytes: &[u8]| {
    let decoded = decode_checked(new, bytes);
    match recognized(bytes) {
        Some((framing, after)) => {
            assert_eq!(decoded, alone(framing, bytes));
            let good_at = |end: usize| FRAMINGS.map(|f| alone(f, &bytes[..end]).counts.good);
            assert!(good_at(after - 1).iter().all(|good| *good < ENOUGH));
            assert_eq!(alone(framing, &bytes[..after]).counts.good, ENOUGH);
        }
        None => {
            assert!(decoded.samples.is_empty());
            let good = FRAMINGS.map(|framing| alone(framing, bytes).counts.good);
            assert!(good.iter().all(|good| *good < ENOUGH));
            assert_eq!(good.into_iter().max(), Some(decoded.counts.good));
            FRAMINGS
                .iter()
                .for_each(|framing| check_found(*framing, bytes));
        }
    }
});

fn new() -> Recognizer {
    Recognizer::new(FullScale::default())
}

/// The framing, and after how many bytes it was known.
fn recognized(bytes: &[u8]) -> Option<(Framing, usize)> {
    let mut recognizer = new();
    let mut samples = Vec::new();
    bytes.iter().zip(1..).find_map(|(&byte, after)| {
        assert!(samples.is_empty(), "samples of an unknown framing");
        recognizer.push(byte, &mut samples);
        Some((recognizer.framing()?, after))
    })
}

/// What the framing's own decoder makes of the line.
fn alone(framing: Framing, bytes: &[u8]) -> Decoded {
    match framing {
        Framing::Teapot => decode(Teapot::default(), bytes),
        Framing::Witmotion => decode(Witmotion::default(), bytes),
        Framing::Mlr => decode(Mlr::default(), bytes),
    }
}

/// Frames after noise are recognised, unless the noise was so much like another
/// framing that one frame more decides; that one may straddle their border.
fn check_found(framing: Framing, noise: &[u8]) {
    let line = [noise, &frames(framing)].concat();
    let (found, _) = recognized(&line).expect("enough good frames");
    let almost = |f: Framing| f != framing && alone(f, noise).counts.good + 1 >= ENOUGH;
    if !FRAMINGS.into_iter().any(almost) {
        assert_eq!(found, framing);
    }
}

/// Frames without a header of another framing in them.
fn frames(framing: Framing) -> Vec<u8> {
    (0..FRAMES as u8)
        .flat_map(|i| match framing {
            Framing::Teapot => encode_teapot(&UnitQuaternion::identity(), i).to_vec(),
            Framing::Witmotion => {
                encode_witmotion(&WitmotionFrame::Angle(Vector3::z() * 0.1)).to_vec()
            }
            Framing::Mlr => encode_mlr(&MlrPayload::RegisterBurst([i; 14]), i, u32::from(i)),
        })
        .collect()
}
