//! Whether the samples of a sensor can be those of a body, one sample at a time.

use std::collections::VecDeque;

use nalgebra::{UnitQuaternion, Vector3};

use super::{
    FaultKind, SampleFault,
    held_values::{Held, HeldValues},
};
use crate::{FullScale, ImuSample, STANDARD_GRAVITY_MPS2};

/// Watches the samples of one sensor, in the sensor's own axes.
///
/// A fault begins with the sample that proves it and is over half a second after the last
/// sample that had it.
#[derive(Debug, Clone)]
pub struct SampleHealth {
    rails: Option<Rails>,
    all: HeldValues<ImuValues>,
    acceleration: HeldValues<[u64; 3]>,
    rate: HeldValues<[u64; 3]>,
    orientation: HeldValues<[u64; 4]>,
    without_gravity_since_s: Option<f64>,
    saturated: RecentTime,
    jumps: RecentTime,
    last: Option<(f64, ImuSample)>,
    walking_since_s: Option<f64>,
    fault: Option<SampleFault>,
    last_seen_s: f64,
}

/// The bits of every channel that says something about the motion.
type ImuValues = [u64; 10];

/// Values that repeat for longer than this while the robot walks are no measurements
/// (ten periods of the slowest usable sensor).
pub(super) const FROZEN_WALKING_S: f64 = 0.2;
/// The same for a robot at rest, and for the accelerations or the rates alone, which a log with
/// few decimals may repeat for some tenths of a second. The noise of an MPU6050 (400 µg/√Hz,
/// 0.005 °/s/√Hz) is several counts of its accelerometer in every range, so that raw samples
/// never repeat for long.
const FROZEN_RAW_S: f64 = 1.0;
/// A body that shows no gravity for so long has fallen by 0.2 m: further than a robot that
/// walks can fall.
const FREE_FALL_S: f64 = 0.2;
/// Specific force below which there is no gravity.
const NO_GRAVITY_MPS2: f64 = 1.0;
/// Time at the end of the range, within a second, that spoils the orientation: an impact
/// may saturate the accelerometer for some milliseconds at each step, but a rate that is
/// cut off is an angle that is lost.
const SATURATED_RATE_S: f64 = 0.02;
const SATURATED_ACCELERATION_S: f64 = 0.2;
/// Beyond every range of the MPU6050 (2000 °/s, 16 g along each axis).
const LARGEST_RATE_RADPS: f64 = 2100.0 * std::f64::consts::PI / 180.0;
const LARGEST_ACCELERATION_MPS2: f64 = 16.5 * STANDARD_GRAVITY_MPS2;
/// A change of orientation from one sample to the next that needs a faster turn than the
/// gyroscope's largest range, and is no rounding.
const JUMP_RAD: f64 = 0.1;
/// So many jumps within half a second are no single bad frame.
const JUMPS: usize = 3;
/// A fault is over when so long none of its samples came.
const OVER_S: f64 = 0.5;

impl SampleHealth {
    /// Nothing heard yet of a sensor with these ranges.
    pub fn new(scale: FullScale) -> Self {
        Self {
            rails: Some(Rails::new(scale)),
            ..Self::without_ranges()
        }
    }

    /// Nothing heard yet of a sensor whose ranges are not known: saturation is not seen.
    pub fn without_ranges() -> Self {
        Self {
            rails: None,
            all: HeldValues::default(),
            acceleration: HeldValues::default(),
            rate: HeldValues::default(),
            orientation: HeldValues::default(),
            without_gravity_since_s: None,
            saturated: RecentTime::new(1.0),
            jumps: RecentTime::new(0.5),
            last: None,
            walking_since_s: None,
            fault: None,
            last_seen_s: f64::NEG_INFINITY,
        }
    }

    /// The fault that the last samples have, if any.
    pub fn fault(&self) -> Option<&SampleFault> {
        self.fault.as_ref()
    }

    /// Takes a sample, whose time is later than that of the last one; `walking` says whether
    /// the robot should be moving. Returns a fault when it begins.
    pub fn take(&mut self, time_s: f64, sample: &ImuSample, walking: bool) -> Option<SampleFault> {
        let found = self.examine(time_s, sample, walking);
        self.last = Some((time_s, *sample));
        match found {
            Some((kind, since_s)) => {
                self.last_seen_s = time_s;
                if self.fault.is_some() {
                    return None;
                }
                self.fault = Some(SampleFault::new(kind, since_s));
                self.fault
            }
            None => {
                if time_s - self.last_seen_s > OVER_S {
                    self.fault = None;
                }
                None
            }
        }
    }

    /// The first fault that this sample and those before it have, and since when.
    fn examine(
        &mut self,
        time_s: f64,
        sample: &ImuSample,
        walking: bool,
    ) -> Option<(FaultKind, f64)> {
        let raw = sample.acceleration_mps2.zip(sample.angular_rate_radps);
        let held_s = self.all.take(time_s, bits_of(sample));
        // Each channel's own run is followed whatever the others do.
        let channels = raw.map(|(acceleration, rate)| {
            (
                self.acceleration.take(time_s, bits(&acceleration)),
                self.rate.take(time_s, bits(&rate)),
            )
        });
        let orientation = sample
            .orientation
            .map(|q| self.orientation.take(time_s, quaternion_bits(&q)));
        let gravity = self.gravity_missing_since(time_s, sample);
        let saturated_s = self.saturated_since(time_s, sample);
        let jumping_s = self.jumping_since(time_s, sample);
        if walking {
            self.walking_since_s.get_or_insert(time_s);
        } else {
            self.walking_since_s = None;
        }
        let walking_since_s = self.walking_since_s;
        let frozen = |held: Held| {
            // A filter may hold the orientation of a robot at rest.
            let standing = raw.is_some() && held.is_frozen(FROZEN_RAW_S);
            let begin_s = walking_since_s.unwrap_or(f64::INFINITY);
            standing || (walking && held.since(begin_s).is_frozen(FROZEN_WALKING_S))
        };
        if let Some(since_s) = gravity {
            return Some((FaultKind::DeadAccelerometer, since_s));
        }
        if frozen(held_s) {
            return Some((FaultKind::Frozen, held_s.since_s));
        }
        if let Some((acceleration, rate)) = channels {
            if acceleration.is_frozen(FROZEN_RAW_S) {
                return Some((FaultKind::DeadAccelerometer, acceleration.since_s));
            }
            if rate.is_frozen(FROZEN_RAW_S) {
                return Some((FaultKind::DeadGyroscope, rate.since_s));
            }
        }
        // The device's own filter has stopped, whatever its raw samples do.
        if let Some(orientation) = orientation.filter(|held| walking && frozen(*held)) {
            return Some((FaultKind::Frozen, orientation.since_s));
        }
        if let Some(since_s) = jumping_s {
            return Some((FaultKind::Impossible, since_s));
        }
        saturated_s.map(|since_s| (FaultKind::Saturated, since_s))
    }

    fn gravity_missing_since(&mut self, time_s: f64, sample: &ImuSample) -> Option<f64> {
        let missing = sample
            .acceleration_mps2
            .is_some_and(|acceleration| acceleration.norm() < NO_GRAVITY_MPS2);
        if !missing {
            self.without_gravity_since_s = None;
            return None;
        }
        let since_s = *self.without_gravity_since_s.get_or_insert(time_s);
        (time_s - since_s > FREE_FALL_S).then_some(since_s)
    }

    fn saturated_since(&mut self, time_s: f64, sample: &ImuSample) -> Option<f64> {
        let step_s = self
            .last
            .map_or(0.0, |(last_s, _)| (time_s - last_s).clamp(0.0, 0.1));
        let rate = sample
            .angular_rate_radps
            .is_some_and(|rate| self.rails.is_some_and(|rails| rails.rate_at_end(&rate)));
        let acceleration = sample.acceleration_mps2.is_some_and(|force| {
            self.rails
                .is_some_and(|rails| rails.acceleration_at_end(&force))
        });
        // One limit for both: a rate's time counts as many times as it is graver.
        let weight = match (rate, acceleration) {
            (true, _) => SATURATED_ACCELERATION_S / SATURATED_RATE_S,
            (false, true) => 1.0,
            (false, false) => 0.0,
        };
        self.saturated.add(time_s, weight * step_s);
        self.saturated.since(SATURATED_ACCELERATION_S)
    }

    fn jumping_since(&mut self, time_s: f64, sample: &ImuSample) -> Option<f64> {
        let beyond = |vector: Option<Vector3<f64>>, largest: f64| {
            vector.is_some_and(|vector| {
                vector
                    .iter()
                    .any(|value| !value.is_finite() || value.abs() > largest)
            })
        };
        let beyond_range = beyond(sample.angular_rate_radps, LARGEST_RATE_RADPS)
            || beyond(sample.acceleration_mps2, LARGEST_ACCELERATION_MPS2);
        let jumps = self.last.is_some_and(|(last_s, last)| {
            let turned = last
                .orientation
                .zip(sample.orientation)
                .map(|(before, after)| before.angle_to(&after));
            let possible_rad = LARGEST_RATE_RADPS * (time_s - last_s).max(0.0) + JUMP_RAD;
            turned.is_some_and(|angle_rad| angle_rad > possible_rad)
        });
        let count = f64::from(u8::from(beyond_range || jumps));
        self.jumps.add(time_s, count);
        self.jumps.since(JUMPS as f64)
    }
}

/// The ends of the sensor's ranges, as it reports them.
#[derive(Debug, Clone, Copy)]
struct Rails {
    acceleration_mps2: f64,
    rate_radps: f64,
}

impl Rails {
    fn new(scale: FullScale) -> Self {
        let counts = f64::from(i16::MAX);
        Self {
            acceleration_mps2: counts / scale.accelerometer.counts_per_g() * STANDARD_GRAVITY_MPS2,
            rate_radps: (counts / scale.gyroscope.counts_per_dps()).to_radians(),
        }
    }

    fn acceleration_at_end(&self, force_mps2: &Vector3<f64>) -> bool {
        at_end(force_mps2, self.acceleration_mps2)
    }

    fn rate_at_end(&self, rate_radps: &Vector3<f64>) -> bool {
        at_end(rate_radps, self.rate_radps)
    }
}

/// Whether a component is within two counts of an end: a device with a larger range than
/// expected passes through there, but does not stay.
fn at_end(vector: &Vector3<f64>, end: f64) -> bool {
    let counts = 2.0 / f64::from(i16::MAX);
    vector
        .iter()
        .any(|value| (value.abs() / end - 1.0).abs() < counts)
}

/// A quantity summed over the last moments.
#[derive(Debug, Clone)]
struct RecentTime {
    keep_s: f64,
    parts: VecDeque<(f64, f64)>,
    sum: f64,
}

impl RecentTime {
    fn new(keep_s: f64) -> Self {
        Self {
            keep_s,
            parts: VecDeque::new(),
            sum: 0.0,
        }
    }

    fn add(&mut self, time_s: f64, amount: f64) {
        if amount > 0.0 {
            self.parts.push_back((time_s, amount));
            self.sum += amount;
        }
        while let Some((_, amount)) = self
            .parts
            .front()
            .copied()
            .filter(|(past_s, _)| *past_s < time_s - self.keep_s)
        {
            self.parts.pop_front();
            self.sum -= amount;
        }
    }

    /// Since when, if the sum reaches `limit`.
    fn since(&self, limit: f64) -> Option<f64> {
        let (first_s, _) = self.parts.front()?;
        (self.sum >= limit).then_some(*first_s)
    }
}

fn bits(vector: &Vector3<f64>) -> [u64; 3] {
    [vector.x, vector.y, vector.z].map(sign_free_zero)
}

/// The bits of a value; a zero has one sign only.
fn sign_free_zero(value: f64) -> u64 {
    (value + 0.0).to_bits()
}

fn bits_of(sample: &ImuSample) -> ImuValues {
    let [ax, ay, az] = sample.acceleration_mps2.map_or([0; 3], |v| bits(&v));
    let [gx, gy, gz] = sample.angular_rate_radps.map_or([0; 3], |v| bits(&v));
    let [i, j, k, w] = sample.orientation.map_or([0; 4], |q| quaternion_bits(&q));
    [ax, ay, az, gx, gy, gz, i, j, k, w]
}

fn quaternion_bits(q: &UnitQuaternion<f64>) -> [u64; 4] {
    [q.i, q.j, q.k, q.w].map(sign_free_zero)
}

#[cfg(test)]
mod tests;
