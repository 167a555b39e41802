//! From bytes to orientation over time.

use mlr_filter::{Axes, unwrapped_rad};
use mlr_imu::{
    CALIBRATION_S, FullScale, Fusion, ImuSample, SampleClock,
    frames::{Counts, Decode, Mlr, Recognizer, Teapot, Witmotion},
};
use nalgebra::Vector3;

use crate::FramingName;

/// Roll, pitch and unwrapped yaw at a time counted from the first sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attitude {
    /// Time since the first sample.
    pub time_s: f64,
    /// The angles in radians.
    pub angles_rad: Axes<f64>,
}

/// Decodes, stamps and, where the device does not, fuses.
pub struct Sensor {
    decoder: Box<dyn Decode + Send>,
    clock: SampleClock,
    lost_before: u64,
    calibration: Calibration,
    last_yaw_rad: Option<f64>,
    samples: Vec<ImuSample>,
}

/// The gyroscope's bias is taken while the robot stands, before fusion begins.
enum Calibration {
    Collecting {
        rates_radps: Vec<Vector3<f64>>,
        begin_s: f64,
    },
    Done(Box<Fusion>),
}

/// Step that fusion expects; each sample is taken with its own.
const NOMINAL_STEP_S: f64 = 0.001;

impl Sensor {
    /// A sensor whose bytes have this framing.
    pub fn new(framing: FramingName) -> Self {
        let scale = FullScale::default();
        let decoder: Box<dyn Decode + Send> = match framing {
            FramingName::Auto => Box::new(Recognizer::new(scale)),
            FramingName::Teapot => Box::<Teapot>::default(),
            FramingName::Witmotion => Box::<Witmotion>::default(),
            FramingName::Mlr => Box::new(Mlr::new(scale)),
        };
        Self {
            decoder,
            clock: SampleClock::default(),
            lost_before: 0,
            calibration: Calibration::Collecting {
                rates_radps: Vec::new(),
                begin_s: 0.0,
            },
            last_yaw_rad: None,
            samples: Vec::new(),
        }
    }

    /// What has become of the bytes so far.
    pub fn counts(&self) -> Counts {
        self.decoder.counts()
    }

    /// Takes bytes that arrived at `arrival_s`; appends what they complete.
    pub fn take(&mut self, arrival_s: f64, bytes: &[u8], attitudes: &mut Vec<Attitude>) {
        let mut samples = std::mem::take(&mut self.samples);
        for &byte in bytes {
            self.decoder.push(byte, &mut samples);
            for sample in samples.drain(..) {
                let lost = self.decoder.counts().lost;
                let missing = lost - self.lost_before;
                self.lost_before = lost;
                let time_s = self.clock.stamp(arrival_s, sample.device_time_us, missing);
                attitudes.extend(self.attitude(time_s, &sample));
            }
        }
        self.samples = samples;
    }

    fn attitude(&mut self, time_s: f64, sample: &ImuSample) -> Option<Attitude> {
        if let Some(orientation) = sample.orientation {
            let (roll, pitch, yaw) = orientation.euler_angles();
            let yaw = self
                .last_yaw_rad
                .map_or(yaw, |last| unwrapped_rad(last, yaw));
            self.last_yaw_rad = Some(yaw);
            let angles_rad = Axes { roll, pitch, yaw };
            return Some(Attitude { time_s, angles_rad });
        }
        let (acceleration, rate) = (sample.acceleration_mps2?, sample.angular_rate_radps?);
        match &mut self.calibration {
            Calibration::Collecting {
                rates_radps,
                begin_s,
            } => {
                if rates_radps.is_empty() {
                    *begin_s = time_s;
                }
                rates_radps.push(rate);
                if time_s - *begin_s >= CALIBRATION_S {
                    let bias = mlr_imu::rest_bias_radps(rates_radps).unwrap_or_default();
                    self.calibration =
                        Calibration::Done(Box::new(Fusion::new(NOMINAL_STEP_S, bias)));
                }
                None
            }
            Calibration::Done(fusion) => Some(Attitude {
                time_s,
                angles_rad: fusion.update(time_s, &acceleration, &rate),
            }),
        }
    }
}
