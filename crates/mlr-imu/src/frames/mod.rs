//! Frames on a serial line.
//!
//! Three framings, each decoded from bytes that arrive in pieces of any size:
//!
//! | framing | device | integrity |
//! |:--|:--|:--|
//! | [`Teapot`] | i2cdevlib's DMP sketch on an Arduino with an MPU6050 | fixed bytes, norm of the quaternion, counter |
//! | [`Witmotion`] | JY61, WT61, BWT61 modules, which carry an MPU6050 | 8-bit sum |
//! | [`Mlr`] | a bridge of one's own between MPU6050 and UART | CRC-16, counter, device time |
//!
//! [`Recognizer`] finds out which of them a line carries.
//!
//! ```
//! use mlr_imu::frames::{Decode, Witmotion};
//!
//! let angles = [0x55, 0x53, 0x3a, 0x00, 0xdf, 0xff, 0x1c, 0x00, 0x58, 0x2d, 0x61];
//! let mut decoder = Witmotion::default();
//! let mut samples = Vec::new();
//! decoder.extend(&angles[..4], &mut samples);
//! assert!(samples.is_empty());
//! decoder.extend(&angles[4..], &mut samples);
//! let roll_deg = samples[0].orientation.unwrap().euler_angles().0.to_degrees();
//! assert!((roll_deg - 0.3186).abs() < 1e-4);
//! ```

mod buffer;
mod dmp;
mod mlr;
mod recognizer;
mod register_burst;
mod teapot;
mod witmotion;

pub use mlr::{Mlr, MlrPayload, encode_mlr};
pub use recognizer::{Framing, Recognizer};
pub use teapot::{Teapot, encode_teapot};
pub use witmotion::{Witmotion, WitmotionFrame, encode_witmotion};

use crate::ImuSample;

/// A streaming decoder: bytes in, samples out.
pub trait Decode {
    /// Takes one byte; appends the sample it completes, if any, to `samples`.
    fn push(&mut self, byte: u8, samples: &mut Vec<ImuSample>);

    /// What has become of the bytes so far.
    fn counts(&self) -> Counts;

    /// Takes bytes cut anywhere.
    fn extend(&mut self, bytes: &[u8], samples: &mut Vec<ImuSample>) {
        for &byte in bytes {
            self.push(byte, samples);
        }
    }
}

/// What a decoder has seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Valid frames.
    pub good: u64,
    /// Frames that began well and failed their check.
    pub bad: u64,
    /// Frames that the sequence counter says were sent and never came.
    pub lost: u64,
    /// Valid frames of a type that carries nothing used here.
    pub skipped: u64,
}

impl Counts {
    /// Counts a good frame, and the lost ones between its sequence counter and
    /// the one before. A counter that jumps by more than half its range is taken
    /// for a restart of the device.
    fn good_in_sequence(&mut self, counter: u8, previous: &mut Option<u8>) {
        self.good += 1;
        if let Some(before) = previous.replace(counter) {
            let missing = counter.wrapping_sub(before).wrapping_sub(1);
            if missing < u8::MAX / 2 {
                self.lost += u64::from(missing);
            }
        }
    }
}
