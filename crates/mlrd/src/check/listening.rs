//! Some seconds of what the sensor says.

use std::time::{Duration, Instant};

use mlr_imu::frames::{Counts, Decode, Framing, Recognizer};
use nalgebra::Vector3;

use crate::{
    Settings,
    line_health::LineFault,
    mounting_check::up,
    sensor::{Heard, Reading as Attitudes, Sensor},
    sensor_fault::{FaultChange, SensorFault},
    source::{Loss, Reading},
};

/// What was heard.
#[derive(Debug, Default)]
pub(super) struct Listened {
    pub(super) time_s: f64,
    pub(super) bytes: usize,
    pub(super) counts: Counts,
    /// The framing of the bytes, whatever the settings say.
    pub(super) framing: Option<Framing>,
    pub(super) line_fault: Option<LineFault>,
    /// The first fault of the sensor.
    pub(super) fault: Option<SensorFault>,
    pub(super) rate_hz: Option<f64>,
    /// Why it gave no more bytes.
    pub(super) lost: Option<Loss>,
    pub(super) rest: Rest,
}

/// What the sensor shows of a body that should be at rest.
#[derive(Debug, Default)]
pub(super) struct Rest {
    readings: u32,
    /// Sum of the directions that point up, in the body's axes.
    up: Vector3<f64>,
    /// Sum of specific forces, and how many there were.
    force_mps2: f64,
    forces: u32,
    /// Least and largest roll and pitch.
    range_rad: Option<[(f64, f64); 2]>,
}

impl Rest {
    fn take(&mut self, reading: &Attitudes) {
        let Some(up) = up(&reading.sample) else {
            return;
        };
        self.readings += 1;
        self.up += up;
        if let Some(force) = reading.sample.acceleration_mps2 {
            self.force_mps2 += force.norm();
            self.forces += 1;
        }
        let angles_rad = &reading.attitude.angles_rad;
        let now = [angles_rad.roll, angles_rad.pitch];
        let range = self
            .range_rad
            .get_or_insert(now.map(|angle| (angle, angle)));
        for ((least, most), angle) in range.iter_mut().zip(now) {
            *least = least.min(angle);
            *most = most.max(angle);
        }
    }

    /// The direction that points up, in the body's axes.
    pub(super) fn up(&self) -> Option<Vector3<f64>> {
        self.up.try_normalize(1e-6)
    }

    /// Mean of the specific force, where the sensor says it.
    pub(super) fn force_mps2(&self) -> Option<f64> {
        (self.forces > 0).then(|| self.force_mps2 / f64::from(self.forces))
    }

    /// How far roll or pitch went to and fro.
    pub(super) fn swing_rad(&self) -> f64 {
        let ranges = self.range_rad.into_iter().flatten();
        ranges.fold(0.0, |swing, (least, most)| swing.max(most - least))
    }
}

/// Listens for so long, or until there is no more.
pub(super) fn listen(port: &mut dyn Reading, settings: &Settings, time: Duration) -> Listened {
    let mut sensor = Sensor::new(settings, None);
    let mut recognizer = Recognizer::new(settings.full_scale);
    let mut heard = Listened::default();
    let begin = Instant::now();
    while begin.elapsed() < time {
        let bytes = match port.read() {
            Ok(bytes) => bytes,
            Err(loss) => {
                heard.lost = Some(loss);
                // The last line may have no end of its own.
                heard.take(&mut sensor, begin.elapsed(), b"\n");
                break;
            }
        };
        heard.bytes += bytes.len();
        recognizer.extend(&bytes, &mut Vec::new());
        if !bytes.is_empty() {
            heard.take(&mut sensor, begin.elapsed(), &bytes);
        }
    }
    heard.time_s = begin.elapsed().as_secs_f64();
    heard.counts = sensor.counts();
    heard.framing = recognizer.framing();
    heard.rate_hz = sensor.take_rate_hz();
    heard
}

/// The framing that a line speaks, if it says enough in this time.
pub(super) fn framing(
    port: &mut dyn Reading,
    settings: &Settings,
    time: Duration,
) -> Option<Framing> {
    let mut recognizer = Recognizer::new(settings.full_scale);
    let begin = Instant::now();
    while begin.elapsed() < time && recognizer.framing().is_none() {
        let bytes = port.read().ok()?;
        recognizer.extend(&bytes, &mut Vec::new());
    }
    recognizer.framing()
}

impl Listened {
    fn take(&mut self, sensor: &mut Sensor, arrival: Duration, bytes: &[u8]) {
        for heard in sensor.take(arrival.as_secs_f64(), bytes, false) {
            match heard {
                Heard::Reading(reading) => self.rest.take(&reading),
                Heard::LineFault(fault) => self.line_fault = Some(fault),
                Heard::Fault(FaultChange::Began(fault)) => {
                    self.fault.get_or_insert(fault);
                }
                Heard::Fault(FaultChange::Over { .. }) => {}
            }
        }
    }
}
