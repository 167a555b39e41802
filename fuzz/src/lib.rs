//! What every decoder must hold to, whatever the bytes.

use mlr_imu::{
    ImuSample,
    frames::{Counts, Decode},
};

/// Frames that are appended to noise.
pub const FRAMES: usize = 8;
/// Largest gap of the sequence counter that counts as lost frames.
const LARGEST_GAP: u64 = 126;

/// What a decoder made of a line.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Decoded {
    /// In the order in which they came.
    pub samples: Vec<ImuSample>,
    /// At the end of the line.
    pub counts: Counts,
}

/// Decodes a line.
pub fn decode(mut decoder: impl Decode, bytes: &[u8]) -> Decoded {
    let mut samples = Vec::new();
    decoder.extend(bytes, &mut samples);
    Decoded {
        samples,
        counts: decoder.counts(),
    }
}

/// Decodes a line whole and in pieces: both give the same, every number is
/// finite, every orientation a rotation, and no more is lost than counters can
/// tell.
pub fn decode_checked<D: Decode>(new: impl Fn() -> D, bytes: &[u8]) -> Decoded {
    let whole = decode(new(), bytes);
    let mut decoder = new();
    let mut samples = Vec::new();
    for piece in pieces(bytes) {
        decoder.extend(piece, &mut samples);
    }
    let counts = decoder.counts();
    assert_eq!(Decoded { samples, counts }, whole);

    whole.samples.iter().for_each(check_sample);
    assert!(counts.lost <= LARGEST_GAP * counts.good.saturating_sub(1));
    whole
}

/// Cuts a line: the low six bits of each piece's first byte are its length
/// less one.
pub fn pieces(mut bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    std::iter::from_fn(move || {
        let length = 1 + usize::from(bytes.first()? & 0x3f);
        let (piece, rest) = bytes.split_at(length.min(bytes.len()));
        bytes = rest;
        Some(piece)
    })
}

fn check_sample(sample: &ImuSample) {
    let mut numbers = [sample.acceleration_mps2, sample.angular_rate_radps]
        .into_iter()
        .flatten()
        .flat_map(|vector| [vector.x, vector.y, vector.z])
        .chain(sample.temperature_c);
    assert!(numbers.all(f64::is_finite), "{sample:?}");
    if let Some(orientation) = sample.orientation {
        let norm = orientation.quaternion().norm();
        assert!((norm - 1.0).abs() < 1e-9, "{sample:?}");
    }
}

/// Decodes frames of a fixed length by trying a new decoder at every byte that
/// no valid frame has covered. Samples and counts that depend on earlier frames
/// may differ.
pub fn scan<D: Decode + Default>(bytes: &[u8], length: usize) -> Decoded {
    let mut scanned = Decoded::default();
    let mut at = 0;
    while let Some(window) = bytes.get(at..at + length) {
        let Decoded { samples, counts } = decode(D::default(), window);
        let is_frame = counts.good + counts.skipped == 1;
        at += if is_frame { length } else { 1 };
        scanned.samples.extend(samples);
        scanned.counts.good += counts.good;
        scanned.counts.bad += counts.bad;
        scanned.counts.skipped += counts.skipped;
    }
    scanned
}

/// Valid frames after noise: of them at most `lost` are not found, and from the
/// third one on the samples are those of a line without noise.
pub fn check_recovery<D: Decode>(
    new: impl Fn() -> D,
    noise: &[u8],
    frames: &[Vec<u8>],
    lost: usize,
) {
    let before = decode(new(), noise);
    let line = [noise, &frames.concat()].concat();
    let after = decode(new(), &line);
    let found = after.counts.good - before.counts.good;
    assert!(found >= (frames.len() - lost) as u64, "{found} {after:?}");
    let settled = decode(new(), &frames[2..].concat());
    assert!(after.samples.ends_with(&settled.samples), "{after:?}");
}
