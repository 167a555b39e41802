//! From bytes to orientation over time.

use mlr_filter::{Axes, unwrapped_rad};
use mlr_imu::{
    CALIBRATION_S, Fusion, ImuSample, Mounting, SampleClock,
    frames::{Counts, Decode, Mlr, Recognizer, Teapot, Witmotion},
};
use nalgebra::Vector3;

use crate::{
    FramingName, Settings,
    line_health::{LineFault, LineHealth},
    spike_filter::SpikeFilter,
};

/// Roll, pitch and unwrapped yaw of the body at a time counted from the first
/// sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attitude {
    /// Time since the first sample.
    pub time_s: f64,
    /// The angles in radians.
    pub angles_rad: Axes<f64>,
}

/// What the sensor says at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// The orientation.
    pub attitude: Attitude,
    /// What it was made of, calibrated, in the body's axes.
    pub sample: ImuSample,
}

/// Decodes, stamps and, where the device does not, fuses.
pub struct Sensor {
    framing: FramingName,
    settings: Settings,
    decoder: Box<dyn Decode + Send>,
    /// Counts of decoders that were given up.
    counts_before: Counts,
    health: LineHealth,
    clock: SampleClock,
    lost_before: u64,
    mounting: Mounting,
    orientation: Orientation,
    spikes: SpikeFilter,
    bias: Bias,
    samples: Vec<ImuSample>,
}

/// The gyroscope's bias, in the body's axes.
#[derive(Debug, Clone, Copy, Default)]
struct Bias {
    /// From an earlier run.
    remembered_radps: Option<Vector3<f64>>,
    /// From this run, with the sensor at rest.
    found_radps: Option<Vector3<f64>>,
}

/// Orientation so far. The gyroscope's bias is taken while the robot stands,
/// before fusion begins.
enum Orientation {
    Calibrating {
        rates_radps: Vec<Vector3<f64>>,
        begin_s: f64,
    },
    Fused {
        fusion: Box<Fusion>,
        last_s: f64,
        yaw_offset_rad: f64,
        last_yaw_rad: f64,
    },
    /// The device's own.
    Given { last_yaw_rad: f64 },
}

/// Step that fusion expects; each sample is taken with its own.
const NOMINAL_STEP_S: f64 = 0.001;
/// After a pause of this length the last orientation says nothing any more.
const PAUSE_S: f64 = 1.0;

impl Sensor {
    /// A sensor as the settings describe it, whose gyroscope showed this bias when
    /// it last stood.
    pub fn new(settings: &Settings, bias_radps: Option<Vector3<f64>>) -> Self {
        let framing = settings.framing();
        Self {
            framing,
            settings: settings.clone(),
            decoder: decoder(framing, settings),
            counts_before: Counts::default(),
            health: LineHealth::new(framing, settings.full_scale),
            clock: SampleClock::default(),
            lost_before: 0,
            mounting: settings.mounting,
            orientation: Orientation::Calibrating {
                rates_radps: Vec::new(),
                begin_s: 0.0,
            },
            spikes: SpikeFilter::default(),
            bias: Bias {
                remembered_radps: bias_radps,
                found_radps: None,
            },
            samples: Vec::new(),
        }
    }

    /// What has become of the bytes so far.
    pub fn counts(&self) -> Counts {
        let (now, before) = (self.decoder.counts(), self.counts_before);
        Counts {
            good: before.good + now.good,
            bad: before.bad + now.bad,
            lost: before.lost + now.lost,
            skipped: before.skipped + now.skipped,
        }
    }

    /// Bias of the gyroscope, if the sensor was seen at rest.
    pub fn gyroscope_bias_radps(&self) -> Option<Vector3<f64>> {
        self.bias.found_radps
    }

    /// Takes bytes that arrived at `arrival_s`; appends what they complete. Tells
    /// when they make no sense.
    pub fn take(
        &mut self,
        arrival_s: f64,
        bytes: &[u8],
        readings: &mut Vec<Reading>,
    ) -> Option<LineFault> {
        let good_before = self.decoder.counts().good;
        let mut samples = std::mem::take(&mut self.samples);
        for &byte in bytes {
            self.decoder.push(byte, &mut samples);
            for sample in samples.drain(..) {
                let lost = self.decoder.counts().lost;
                let missing = lost - self.lost_before;
                self.lost_before = lost;
                let time_s = self.clock.stamp(arrival_s, sample.device_time_us, missing);
                let sample = self.mounting.in_body_axes(&sample);
                let attitude = self.attitude(time_s, &sample);
                let reading = attitude.map(|attitude| Reading { attitude, sample });
                readings.extend(reading.and_then(|reading| self.spikes.push(reading)));
            }
        }
        self.samples = samples;
        let good = self.decoder.counts().good - good_before;
        let fault = self.health.hear(arrival_s, bytes, good);
        if fault.is_some() && self.framing == FramingName::Auto {
            self.recognise_anew();
        }
        fault
    }

    /// The port was opened: nothing has been waiting on the way.
    pub fn reconnected(&mut self) {
        self.clock.interrupted();
    }

    /// The line may carry another framing than it used to.
    fn recognise_anew(&mut self) {
        self.counts_before = self.counts();
        self.decoder = decoder(self.framing, &self.settings);
        self.lost_before = 0;
    }

    fn attitude(&mut self, time_s: f64, sample: &ImuSample) -> Option<Attitude> {
        if let Some(orientation) = sample.orientation {
            let (roll, pitch, yaw) = orientation.euler_angles();
            let yaw = match self.orientation {
                Orientation::Given { last_yaw_rad } => unwrapped_rad(last_yaw_rad, yaw),
                _ => yaw,
            };
            self.orientation = Orientation::Given { last_yaw_rad: yaw };
            let angles_rad = Axes { roll, pitch, yaw };
            return Some(Attitude { time_s, angles_rad });
        }
        let (acceleration, rate) = (sample.acceleration_mps2?, sample.angular_rate_radps?);
        match &mut self.orientation {
            Orientation::Calibrating {
                rates_radps,
                begin_s,
            } => {
                if rates_radps.is_empty() {
                    *begin_s = time_s;
                }
                rates_radps.push(rate);
                if time_s - *begin_s >= CALIBRATION_S {
                    self.bias.found_radps = mlr_imu::rest_bias_radps(rates_radps);
                    self.orientation = self.fusion_from(time_s, 0.0);
                }
                None
            }
            Orientation::Given { last_yaw_rad } => {
                let yaw_rad = *last_yaw_rad;
                self.orientation = self.fusion_from(time_s, yaw_rad);
                None
            }
            Orientation::Fused {
                fusion,
                last_s,
                yaw_offset_rad,
                last_yaw_rad,
            } => {
                let pause_s = time_s - std::mem::replace(last_s, time_s);
                if pause_s > PAUSE_S {
                    let yaw_rad = *last_yaw_rad;
                    self.orientation = self.fusion_from(time_s, yaw_rad);
                    return None;
                }
                let mut angles_rad = fusion.update(time_s, &acceleration, &rate);
                angles_rad.yaw += *yaw_offset_rad;
                *last_yaw_rad = angles_rad.yaw;
                Some(Attitude { time_s, angles_rad })
            }
        }
    }

    /// Fusion that begins now, with yaw where it was last seen.
    fn fusion_from(&self, now_s: f64, yaw_rad: f64) -> Orientation {
        let bias = self.bias.found_radps.or(self.bias.remembered_radps);
        Orientation::Fused {
            fusion: Box::new(Fusion::new(NOMINAL_STEP_S, bias.unwrap_or_default())),
            last_s: now_s,
            yaw_offset_rad: yaw_rad,
            last_yaw_rad: yaw_rad,
        }
    }
}

fn decoder(framing: FramingName, settings: &Settings) -> Box<dyn Decode + Send> {
    match framing {
        FramingName::Auto => Box::new(Recognizer::new(settings.full_scale)),
        FramingName::Teapot => Box::<Teapot>::default(),
        FramingName::Witmotion => Box::<Witmotion>::default(),
        FramingName::Mlr => Box::new(Mlr::new(settings.full_scale)),
    }
}

#[cfg(test)]
mod tests {
    use mlr_imu::frames::{MlrPayload, encode_mlr, encode_teapot};
    use nalgebra::UnitQuaternion;

    use super::*;

    /// A sensor at rest, tilted by `roll_rad`, whose gyroscope shows 65 counts
    /// (half a degree per second) about z.
    fn resting(index: u32, roll_rad: f64) -> Vec<u8> {
        let up = [0.0, roll_rad.sin(), roll_rad.cos()];
        let mut burst = [0; 14];
        for axis in 0..3 {
            let counts = (up[axis] * 16384.0).round() as i16;
            burst[2 * axis..][..2].copy_from_slice(&counts.to_be_bytes());
        }
        burst[12..].copy_from_slice(&65_i16.to_be_bytes());
        encode_mlr(&MlrPayload::RegisterBurst(burst), index as u8, index * 1000)
    }

    #[test]
    fn a_sensor_at_rest_shows_its_tilt_and_its_bias() {
        let mut sensor = Sensor::new(&Settings::default(), None);
        let mut readings = Vec::new();
        for i in 0..3000 {
            sensor.take(f64::from(i) * 1e-3, &resting(i, 0.1), &mut readings);
        }
        let last = readings.last().unwrap().attitude;
        assert!((last.angles_rad.roll - 0.1).abs() < 0.002, "{last:?}");
        assert!(last.angles_rad.yaw.abs() < 0.001, "{last:?}");
        let bias = sensor.gyroscope_bias_radps().unwrap().z.to_degrees();
        assert!((bias - 65.0 / 131.0).abs() < 1e-9, "{bias}");
    }

    #[test]
    fn a_pause_begins_fusion_anew_and_keeps_yaw() {
        let mut sensor = Sensor::new(&Settings::default(), Some(Vector3::zeros()));
        let mut readings = Vec::new();
        for i in (0..2000).chain(9000..9100) {
            let roll_rad = if i < 2000 { 0.0 } else { 0.3 };
            sensor.take(f64::from(i) * 1e-3, &resting(i, roll_rad), &mut readings);
        }
        let after = readings
            .iter()
            .find(|reading| reading.attitude.time_s > 8.5)
            .unwrap();
        assert!(
            (after.attitude.angles_rad.roll - 0.3).abs() < 0.01,
            "{after:?}"
        );
    }

    #[test]
    fn another_module_is_understood_when_the_framing_is_open() {
        let mut sensor = Sensor::new(&Settings::default(), None);
        let mut readings = Vec::new();
        for i in 0..100 {
            sensor.take(f64::from(i) * 1e-3, &resting(i, 0.0), &mut readings);
        }
        let fused = readings.len();
        let mut faults = Vec::new();
        for i in 0..1000_u32 {
            let frame = encode_teapot(&UnitQuaternion::identity(), i as u8);
            faults.extend(sensor.take(1.0 + f64::from(i) * 0.01, &frame, &mut readings));
        }
        assert_eq!(faults.len(), 1);
        assert!(readings.len() > fused + 700, "{}", readings.len());
        assert!(sensor.counts().good > 800);
    }
}
