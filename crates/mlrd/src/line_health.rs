//! Why bytes arrive and no frame is understood.

use std::fmt;

use mlr_imu::{
    FullScale,
    frames::{Decode, Framing, Recognizer},
};

use crate::FramingName;

/// Watches whether bytes become frames.
pub struct LineHealth {
    told: FramingName,
    scale: FullScale,
    trouble: Option<Trouble>,
}

/// A stretch of bytes without a valid frame.
struct Trouble {
    since_s: f64,
    bytes: u64,
    recognizer: Recognizer,
    complained: bool,
}

/// What is wrong with a line that delivers bytes.
#[derive(Debug, Clone, PartialEq)]
pub enum LineFault {
    /// It speaks another framing than told or than it used to.
    OtherFraming {
        /// What was expected.
        told: FramingName,
        /// What it is.
        found: Framing,
    },
    /// Lines of text hold no samples.
    NoSamples {
        /// Bytes without a sample.
        bytes: u64,
        /// How long they took.
        seconds: f64,
    },
    /// No framing fits: a wrong speed, as a rule.
    Unintelligible {
        /// Bytes without a valid frame.
        bytes: u64,
        /// How long they took.
        seconds: f64,
    },
}

impl fmt::Display for LineFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OtherFraming { told, found } => {
                let told = format!("{told:?}").to_lowercase();
                write!(f, "the line carries {found} frames, expected {told}")
            }
            Self::NoSamples { bytes, seconds } => write!(
                f,
                "{bytes} bytes in {seconds:.0} s and no sample: expected lines of numbers below a \
                 line of names such as t_s,ax_mps2,ay_mps2,az_mps2,gx_radps,gy_radps,gz_radps, or \
                 JSON objects with these keys"
            ),
            Self::Unintelligible { bytes, seconds } => write!(
                f,
                "{bytes} bytes in {seconds:.0} s and no valid frame: the speed of the port is wrong, \
                 or the device speaks a framing that is not known"
            ),
        }
    }
}

/// So long may bytes make no frame.
const PATIENCE_S: f64 = 2.0;
/// So many bytes are needed to judge a line.
const ENOUGH_BYTES: u64 = 200;

impl LineHealth {
    /// Nothing heard yet of a line that should carry this framing.
    pub fn new(told: FramingName, scale: FullScale) -> Self {
        Self {
            told,
            scale,
            trouble: None,
        }
    }

    /// Takes bytes that arrived at `arrival_s` and made `good` valid frames.
    /// Tells once per stretch what is wrong with it.
    pub fn hear(&mut self, arrival_s: f64, bytes: &[u8], good: u64) -> Option<LineFault> {
        if good > 0 {
            self.trouble = None;
            return None;
        }
        let scale = self.scale;
        let trouble = self.trouble.get_or_insert_with(|| Trouble {
            since_s: arrival_s,
            bytes: 0,
            recognizer: Recognizer::new(scale),
            complained: false,
        });
        trouble.bytes += bytes.len() as u64;
        if trouble.complained {
            return None;
        }
        trouble.recognizer.extend(bytes, &mut Vec::new());
        let seconds = arrival_s - trouble.since_s;
        if seconds < PATIENCE_S || trouble.bytes < ENOUGH_BYTES {
            return None;
        }
        trouble.complained = true;
        let bytes = trouble.bytes;
        Some(match trouble.recognizer.framing() {
            _ if self.told == FramingName::Lines => LineFault::NoSamples { bytes, seconds },
            Some(found) => LineFault::OtherFraming {
                told: self.told,
                found,
            },
            None => LineFault::Unintelligible { bytes, seconds },
        })
    }
}

#[cfg(test)]
mod tests {
    use mlr_imu::frames::encode_teapot;
    use nalgebra::UnitQuaternion;

    use super::*;

    fn hear_for_5_s(health: &mut LineHealth, piece: &[u8], good: u64) -> Vec<LineFault> {
        (0..50)
            .filter_map(|i| health.hear(f64::from(i) * 0.1, piece, good))
            .collect()
    }

    #[test]
    fn a_healthy_line_is_not_complained_of() {
        let mut health = LineHealth::new(FramingName::Teapot, FullScale::default());
        assert!(hear_for_5_s(&mut health, &[1; 14], 1).is_empty());
    }

    #[test]
    fn another_framing_is_named_once() {
        let mut health = LineHealth::new(FramingName::Witmotion, FullScale::default());
        let frame = encode_teapot(&UnitQuaternion::identity(), 3);
        let faults = hear_for_5_s(&mut health, &frame, 0);
        assert_eq!(faults.len(), 1);
        let said = faults[0].to_string();
        assert!(
            said.contains("teapot") && said.contains("expected witmotion"),
            "{said}"
        );
    }

    #[test]
    fn garbage_is_blamed_on_the_speed() {
        let mut health = LineHealth::new(FramingName::Auto, FullScale::default());
        let faults = hear_for_5_s(&mut health, &[0xf0, 0x1f, 0x80, 0x7e], 0);
        assert!(matches!(faults[..], [LineFault::Unintelligible { .. }]));
        assert!(faults[0].to_string().contains("speed"));
    }

    #[test]
    fn text_without_samples_is_told_what_was_expected() {
        let mut health = LineHealth::new(FramingName::Lines, FullScale::default());
        let faults = hear_for_5_s(&mut health, b"1.0,2.0,3.0,4.0\n", 0);
        assert!(faults[0].to_string().contains("t_s,ax_mps2"));
    }

    #[test]
    fn a_few_stray_bytes_are_no_line() {
        let mut health = LineHealth::new(FramingName::Auto, FullScale::default());
        assert!(hear_for_5_s(&mut health, &[0x55], 0).is_empty());
    }
}
