//! From bytes to orientation over time.

use mlr_imu::{
    ImuSample, Mounting, SampleClock, SampleLines,
    frames::{Counts, Decode, Mlr, Recognizer, Teapot, Witmotion},
};
use nalgebra::Vector3;

use crate::{
    FramingName, Settings,
    attitude::{Attitude, AttitudeEstimator},
    line_health::{LineFault, LineHealth},
    sample_rate::SampleRate,
    sensor_fault::{FaultChange, FaultWatch, Moment, SensorFault},
    spike_filter::SpikeFilter,
};

/// What the sensor says at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// The orientation.
    pub attitude: Attitude,
    /// What it was made of, calibrated, in the body's axes.
    pub sample: ImuSample,
}

/// What bytes from the sensor amount to, in the order in which it came.
#[derive(Debug, Clone, PartialEq)]
pub enum Heard {
    /// A reading. Between the beginning and the end of a fault it says nothing about the
    /// robot.
    Reading(Reading),
    /// The bytes make no sense.
    LineFault(LineFault),
    /// They do, and what they say does not, or does again.
    Fault(FaultChange),
}

/// Decodes, stamps, checks and, where the device does not, fuses.
pub struct Sensor {
    framing: FramingName,
    settings: Settings,
    decoder: Box<dyn Decode + Send>,
    /// Counts of decoders that were given up.
    counts_before: Counts,
    health: LineHealth,
    clock: SampleClock,
    lost_before: u64,
    rate: SampleRate,
    mounting: Mounting,
    faults: FaultWatch,
    attitude: AttitudeEstimator,
    spikes: SpikeFilter,
    samples: Vec<ImuSample>,
}

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
            rate: SampleRate::default(),
            mounting: settings.mounting,
            faults: FaultWatch::new(settings.full_scale, settings.mounting),
            attitude: AttitudeEstimator::new(bias_radps),
            spikes: SpikeFilter::default(),
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

    /// Bias of the gyroscope, if the sensor was seen at rest and is in order.
    pub fn gyroscope_bias_radps(&self) -> Option<Vector3<f64>> {
        let found_radps = self.attitude.bias_radps();
        found_radps.filter(|_| self.fault().is_none())
    }

    /// What is wrong with the sensor now.
    pub fn fault(&self) -> Option<&SensorFault> {
        self.faults.current()
    }

    /// Samples per second since this was last asked, by the samples' own time; `None` where
    /// none came.
    pub fn take_rate_hz(&mut self) -> Option<f64> {
        self.rate.take_hz()
    }

    /// Takes bytes that arrived at `arrival_s`, from a robot that should be `walking` or
    /// not; returns what they amount to.
    pub fn take(&mut self, arrival_s: f64, bytes: &[u8], walking: bool) -> Vec<Heard> {
        let mut heard = Vec::new();
        let good_before = self.decoder.counts().good;
        let mut samples = std::mem::take(&mut self.samples);
        for &byte in bytes {
            self.decoder.push(byte, &mut samples);
            for sample in samples.drain(..) {
                let lost = self.decoder.counts().lost;
                let missing = lost - self.lost_before;
                self.lost_before = lost;
                let time_s = self.clock.stamp(arrival_s, sample.device_time_us, missing);
                let moment = Moment { time_s, arrival_s };
                self.take_sample(moment, &sample, walking, &mut heard);
            }
        }
        self.samples = samples;
        let good = self.decoder.counts().good - good_before;
        if let Some(fault) = self.health.hear(arrival_s, bytes, good) {
            heard.push(Heard::LineFault(fault));
            if self.framing == FramingName::Auto {
                self.recognise_anew();
            }
        }
        heard
    }

    fn take_sample(
        &mut self,
        moment: Moment,
        sample: &ImuSample,
        walking: bool,
        heard: &mut Vec<Heard>,
    ) {
        let time_s = moment.time_s;
        self.rate.count(time_s);
        let in_body_axes = self.mounting.in_body_axes(sample);
        let change = self.faults.take(moment, sample, &in_body_axes, walking);
        if let Some(change) = change {
            match &change {
                FaultChange::Began(fault) => self.attitude.doubt_bias(fault.since_s),
                FaultChange::Over { .. } => {
                    heard.extend(self.spikes.flush().map(Heard::Reading));
                    self.attitude.restart(time_s);
                }
            }
            heard.push(Heard::Fault(change));
        }
        let faulty = self.faults.current().is_some();
        let attitude = self.attitude.update(time_s, &in_body_axes, faulty);
        let reading = attitude.map(|attitude| Reading {
            attitude,
            sample: in_body_axes,
        });
        let passed = reading.and_then(|reading| self.spikes.push(reading));
        heard.extend(passed.map(Heard::Reading));
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
}

fn decoder(framing: FramingName, settings: &Settings) -> Box<dyn Decode + Send> {
    match framing {
        FramingName::Auto => Box::new(Recognizer::new(settings.full_scale)),
        FramingName::Teapot => Box::<Teapot>::default(),
        FramingName::Witmotion => Box::<Witmotion>::default(),
        FramingName::Mlr => Box::new(Mlr::new(settings.full_scale)),
        FramingName::Lines => Box::<SampleLines>::default(),
    }
}

#[cfg(test)]
mod tests {
    use mlr_imu::frames::{MlrPayload, encode_mlr, encode_teapot};
    use nalgebra::UnitQuaternion;

    use super::*;

    /// A sensor at rest, tilted by `roll_rad`, whose gyroscope shows 65 or 66 counts
    /// (half a degree per second) about z.
    fn resting(index: u32, roll_rad: f64) -> Vec<u8> {
        resting_with(index, roll_rad, (index % 2) as i16)
    }

    fn resting_with(index: u32, roll_rad: f64, noise_counts: i16) -> Vec<u8> {
        let up = [0.0, roll_rad.sin(), roll_rad.cos()];
        let mut burst = [0; 14];
        for axis in 0..3 {
            let counts = (up[axis] * 16384.0).round() as i16;
            burst[2 * axis..][..2].copy_from_slice(&counts.to_be_bytes());
        }
        burst[..2].copy_from_slice(&noise_counts.to_be_bytes());
        burst[12..].copy_from_slice(&(65 + noise_counts).to_be_bytes());
        encode_mlr(&MlrPayload::RegisterBurst(burst), index as u8, index * 1000)
    }

    /// Readings of what is sent, and everything else that was heard.
    fn hear(
        sensor: &mut Sensor,
        frames: impl IntoIterator<Item = (f64, Vec<u8>)>,
    ) -> (Vec<Reading>, Vec<Heard>) {
        let (mut readings, mut others) = (Vec::new(), Vec::new());
        for (arrival_s, frame) in frames {
            for heard in sensor.take(arrival_s, &frame, false) {
                match heard {
                    Heard::Reading(reading) => readings.push(reading),
                    other => others.push(other),
                }
            }
        }
        (readings, others)
    }

    fn at_1_khz(index: u32, roll_rad: f64) -> (f64, Vec<u8>) {
        (f64::from(index) * 1e-3, resting(index, roll_rad))
    }

    #[test]
    fn a_sensor_at_rest_shows_its_tilt_its_bias_and_its_rate() {
        let mut sensor = Sensor::new(&Settings::default(), None);
        let (readings, others) = hear(&mut sensor, (0..3000).map(|i| at_1_khz(i, 0.1)));
        assert_eq!(others, []);
        let last = readings.last().unwrap().attitude;
        assert!((last.angles_rad.roll - 0.1).abs() < 0.002, "{last:?}");
        assert!(last.angles_rad.yaw.abs() < 0.001, "{last:?}");
        let bias = sensor.gyroscope_bias_radps().unwrap().z.to_degrees();
        assert!((bias - 65.5 / 131.0).abs() < 0.1 / 131.0, "{bias}");
        let rate_hz = sensor.take_rate_hz().unwrap();
        assert!((rate_hz - 1000.0).abs() < 1.0, "{rate_hz}");
        assert_eq!(sensor.take_rate_hz(), None);
    }

    #[test]
    fn a_pause_begins_fusion_anew_and_keeps_yaw() {
        let mut sensor = Sensor::new(&Settings::default(), Some(Vector3::zeros()));
        let frames = (0..2000).chain(9000..9100).map(|i| {
            let roll_rad = if i < 2000 { 0.0 } else { 0.3 };
            at_1_khz(i, roll_rad)
        });
        let (readings, _) = hear(&mut sensor, frames);
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
        let (fused, _) = hear(&mut sensor, (0..100).map(|i| at_1_khz(i, 0.0)));
        let teapots = (0..1000_u32).map(|i| {
            let frame = encode_teapot(&UnitQuaternion::identity(), i as u8);
            (1.0 + f64::from(i) * 0.01, frame.to_vec())
        });
        let (readings, others) = hear(&mut sensor, teapots);
        assert!(matches!(others[..], [Heard::LineFault(_)]), "{others:?}");
        assert!(readings.len() > fused.len() + 700, "{}", readings.len());
        assert!(sensor.counts().good > 800);
    }

    #[test]
    fn what_a_frozen_sensor_shows_is_recorded_and_its_bias_is_not_believed() {
        let mut sensor = Sensor::new(&Settings::default(), None);
        let frozen = |i| (f64::from(i) * 1e-3, resting_with(i, 0.0, 1));
        let (readings, others) = hear(&mut sensor, (0..3000).map(frozen));
        let [Heard::Fault(FaultChange::Began(fault))] = others.as_slice() else {
            panic!("{others:?}");
        };
        assert_eq!((fault.name, sensor.fault()), ("frozen", Some(fault)));
        assert!(readings.len() > 2400, "{}", readings.len());
        assert_eq!(sensor.gyroscope_bias_radps(), None);

        let (readings, others) = hear(&mut sensor, (3000..6000).map(|i| at_1_khz(i, 0.2)));
        assert!(
            matches!(others[..], [Heard::Fault(FaultChange::Over { .. })]),
            "{others:?}"
        );
        assert_eq!(sensor.fault(), None);
        let bias = sensor.gyroscope_bias_radps().unwrap().z.to_degrees();
        assert!((bias - 65.5 / 131.0).abs() < 0.1 / 131.0, "{bias}");
        let last = readings.last().unwrap().attitude;
        assert!((last.angles_rad.roll - 0.2).abs() < 0.002, "{last:?}");
    }
}
