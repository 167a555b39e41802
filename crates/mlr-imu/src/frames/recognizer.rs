//! Finds out which framing a line carries.

use std::fmt;

use super::{Counts, Decode, Mlr, Teapot, Witmotion};
use crate::{FullScale, ImuSample};

/// Good frames that decide, if no other framing has as many.
const ENOUGH: u64 = 5;
/// Samples kept per candidate while undecided.
const KEPT: usize = 64;

/// The framings that are told apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Framing {
    /// i2cdevlib's teapot packets.
    Teapot,
    /// WitMotion frames.
    Witmotion,
    /// This project's bridge frames.
    Mlr,
}

impl fmt::Display for Framing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Teapot => "teapot",
            Self::Witmotion => "witmotion",
            Self::Mlr => "mlr",
        })
    }
}

/// A decoder for a line of unknown framing: lets every decoder listen until one
/// has understood a few frames, then that one alone goes on. What it understood
/// until then is not lost.
pub struct Recognizer {
    candidates: Vec<Candidate>,
}

struct Candidate {
    framing: Framing,
    decoder: Box<dyn Decode + Send>,
    samples: Vec<ImuSample>,
}

impl Recognizer {
    /// Listens for every framing.
    pub fn new(scale: FullScale) -> Self {
        let candidate = |framing, decoder| Candidate {
            framing,
            decoder,
            samples: Vec::new(),
        };
        Self {
            candidates: vec![
                candidate(Framing::Teapot, Box::<Teapot>::default()),
                candidate(Framing::Witmotion, Box::<Witmotion>::default()),
                candidate(Framing::Mlr, Box::new(Mlr::new(scale))),
            ],
        }
    }

    /// The framing, once it is known.
    pub fn framing(&self) -> Option<Framing> {
        match self.candidates.as_slice() {
            [only] => Some(only.framing),
            _ => None,
        }
    }

    fn best(&self) -> Option<&Candidate> {
        self.candidates
            .iter()
            .max_by_key(|candidate| candidate.decoder.counts().good)
    }
}

impl Decode for Recognizer {
    fn push(&mut self, byte: u8, samples: &mut Vec<ImuSample>) {
        if let [only] = self.candidates.as_mut_slice() {
            only.decoder.push(byte, samples);
            return;
        }
        for candidate in &mut self.candidates {
            candidate.decoder.push(byte, &mut candidate.samples);
            let surplus = candidate.samples.len().saturating_sub(KEPT);
            candidate.samples.drain(..surplus);
        }
        let decided = self
            .best()
            .filter(|best| best.decoder.counts().good >= ENOUGH)
            .map(|best| best.framing);
        if let Some(framing) = decided {
            self.candidates
                .retain(|candidate| candidate.framing == framing);
            for candidate in &mut self.candidates {
                samples.append(&mut candidate.samples);
            }
        }
    }

    fn counts(&self) -> Counts {
        self.best()
            .map_or_else(Counts::default, |best| best.decoder.counts())
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, Vector3};
    use proptest::prelude::*;

    use super::*;
    use crate::frames::{MlrPayload, WitmotionFrame, encode_mlr, encode_teapot, encode_witmotion};

    fn stream(framing: Framing, frames: u8) -> Vec<u8> {
        (0..frames)
            .flat_map(|i| match framing {
                Framing::Teapot => encode_teapot(&UnitQuaternion::identity(), i).to_vec(),
                Framing::Witmotion => {
                    encode_witmotion(&WitmotionFrame::Angle(Vector3::z() * 0.1)).to_vec()
                }
                Framing::Mlr => {
                    encode_mlr(&MlrPayload::RegisterBurst([i; 14]), i, u32::from(i) * 1000)
                }
            })
            .collect()
    }

    fn framing() -> impl Strategy<Value = Framing> {
        prop::sample::select(vec![Framing::Teapot, Framing::Witmotion, Framing::Mlr])
    }

    proptest! {
        #[test]
        fn every_framing_is_recognised_and_nothing_is_lost(
            framing in framing(),
            pieces in prop::collection::vec(1_usize..40, 1..50),
        ) {
            let bytes = stream(framing, 20);
            let mut recognizer = Recognizer::new(FullScale::default());
            let mut samples = Vec::new();
            let mut rest = bytes.as_slice();
            for size in pieces.iter().cycle() {
                let (piece, more) = rest.split_at((*size).min(rest.len()));
                recognizer.extend(piece, &mut samples);
                rest = more;
                if rest.is_empty() {
                    break;
                }
            }
            prop_assert_eq!(recognizer.framing(), Some(framing));
            prop_assert_eq!(samples.len(), 20);
            prop_assert_eq!(recognizer.counts().good, 20);
        }

        #[test]
        fn noise_is_no_framing(bytes in prop::collection::vec(any::<u8>(), 0..2000)) {
            let mut recognizer = Recognizer::new(FullScale::default());
            let mut samples = Vec::new();
            recognizer.extend(&bytes, &mut samples);
            prop_assert_eq!(recognizer.framing(), None);
            prop_assert!(samples.is_empty());
        }
    }
}
