//! What is wrong with a sensor whose frames are understood.

use mlr_imu::{
    FullScale, ImuSample, Mounting,
    quality::{SampleFault, SampleHealth},
};

use crate::{
    mounting_check::{MountingCheck, Turn},
    stopped_clock::StoppedClock,
};

/// Samples from which nothing may be concluded.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorFault {
    /// Its short name, as in `frozen`.
    pub name: &'static str,
    /// What is wrong, in words.
    pub reason: String,
    /// Time of the first sample that had it.
    pub since_s: f64,
}

/// When a sample was taken, and when it arrived.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Time since the first sample.
    pub time_s: f64,
    /// Time of arrival, by any steady clock.
    pub arrival_s: f64,
}

/// A fault has begun, or the sensor has none any more.
#[derive(Debug, Clone, PartialEq)]
pub enum FaultChange {
    /// This one began.
    Began(SensorFault),
    /// The last one is over.
    Over {
        /// The fault that began last.
        name: &'static str,
        /// Time from the first sample that was wrong.
        lasted_s: f64,
    },
}

/// Follows the faults of one sensor. What is wrong with the samples themselves comes
/// before how the sensor is mounted, which only good samples tell.
pub struct FaultWatch {
    samples: SampleHealth,
    clock: StoppedClock,
    mounting: MountingCheck,
    bad_samples: Option<SensorFault>,
    upside_down: Option<SensorFault>,
    /// Since when the sensor has had one fault or another.
    since_s: f64,
}

impl From<SampleFault> for SensorFault {
    fn from(fault: SampleFault) -> Self {
        Self {
            name: fault.kind().name(),
            reason: fault.to_string(),
            since_s: fault.since_s(),
        }
    }
}

impl FaultWatch {
    /// Watches a sensor with these ranges and this mounting.
    pub fn new(scale: FullScale, mounting: Mounting) -> Self {
        Self {
            samples: SampleHealth::new(scale),
            clock: StoppedClock::default(),
            mounting: MountingCheck::new(mounting),
            bad_samples: None,
            upside_down: None,
            since_s: 0.0,
        }
    }

    /// The fault that the sensor has now.
    pub fn current(&self) -> Option<&SensorFault> {
        self.bad_samples.as_ref().or(self.upside_down.as_ref())
    }

    /// Takes a sample as the sensor gave it, and in the body's axes; `walking` says whether
    /// the robot should be moving.
    pub fn take(
        &mut self,
        moment: Moment,
        sample: &ImuSample,
        in_body_axes: &ImuSample,
        walking: bool,
    ) -> Option<FaultChange> {
        let Moment { time_s, arrival_s } = moment;
        let began = self.samples.take(time_s, sample, walking);
        let stopped = self.clock.take(arrival_s, sample.device_time_us);
        let new = match began {
            Some(fault) => Some(fault.into()),
            None => (stopped && self.bad_samples.is_none()).then(|| SensorFault {
                name: "frozen",
                reason: "the device's clock stands still: it repeats one frame".into(),
                since_s: time_s,
            }),
        };
        if let Some(fault) = new {
            let fault = self.begin(fault);
            self.bad_samples = Some(fault.clone());
            return Some(FaultChange::Began(fault));
        }
        if stopped || self.samples.fault().is_some() {
            return None;
        }
        let good_again = self.bad_samples.take();
        let turned_over = match self.mounting.take(time_s, in_body_axes) {
            Some(Turn::UpsideDown { since_s, reason }) => {
                let fault = self.begin(SensorFault {
                    name: "upside_down",
                    reason,
                    since_s,
                });
                self.upside_down = Some(fault.clone());
                return Some(FaultChange::Began(fault));
            }
            Some(Turn::Upright) => self.upside_down.take(),
            None => None,
        };
        if self.upside_down.is_some() {
            return None;
        }
        let over = good_again.or(turned_over)?;
        Some(FaultChange::Over {
            name: over.name,
            lasted_s: time_s - self.since_s,
        })
    }

    fn begin(&mut self, fault: SensorFault) -> SensorFault {
        if self.current().is_none() {
            self.since_s = fault.since_s;
        }
        fault
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    /// Every sample differs from the one before it, as noise makes them.
    fn noisy(index: u32, up_mps2: f64) -> ImuSample {
        let noise = f64::from(index % 7) * 0.01;
        ImuSample {
            acceleration_mps2: Some(Vector3::new(noise, 0.0, up_mps2)),
            angular_rate_radps: Some(Vector3::repeat(noise)),
            ..ImuSample::default()
        }
    }

    fn changes(
        watch: &mut FaultWatch,
        from: u32,
        to: u32,
        sample: impl Fn(u32) -> ImuSample,
    ) -> Vec<FaultChange> {
        (from..to)
            .filter_map(|index| {
                let sample = sample(index);
                let time_s = f64::from(index) * 1e-3;
                let moment = Moment {
                    time_s,
                    arrival_s: time_s,
                };
                watch.take(moment, &sample, &sample, true)
            })
            .collect()
    }

    #[test]
    fn a_frozen_sensor_is_told_once_and_recovers() {
        let mut watch = FaultWatch::new(FullScale::default(), Mounting::default());
        assert!(changes(&mut watch, 0, 3000, |i| noisy(i, 9.8)).is_empty());
        let told = changes(&mut watch, 3000, 6000, |_| noisy(1, 9.8));
        let [FaultChange::Began(fault)] = told.as_slice() else {
            panic!("{told:?}");
        };
        assert_eq!(fault.name, "frozen");
        assert!((fault.since_s - 3.0).abs() < 0.01);
        assert_eq!(watch.current(), Some(fault));
        let told = changes(&mut watch, 6000, 9000, |i| noisy(i, 9.8));
        let [FaultChange::Over { name, lasted_s }] = told.as_slice() else {
            panic!("{told:?}");
        };
        assert_eq!(*name, "frozen");
        assert!((3.0..4.0).contains(lasted_s), "{lasted_s}");
        assert_eq!(watch.current(), None);
    }

    #[test]
    fn a_sensor_upside_down_stays_faulty_when_another_fault_is_over() {
        let mut watch = FaultWatch::new(FullScale::default(), Mounting::default());
        let names = |changes: &[FaultChange]| -> Vec<&str> {
            changes
                .iter()
                .map(|change| match change {
                    FaultChange::Began(fault) => fault.name,
                    FaultChange::Over { .. } => "over",
                })
                .collect()
        };
        let told = changes(&mut watch, 0, 3000, |i| noisy(i, -9.8));
        assert_eq!(names(&told), ["upside_down"]);
        let told = changes(&mut watch, 3000, 5000, |_| noisy(1, -9.8));
        assert_eq!(names(&told), ["frozen"]);
        assert!(changes(&mut watch, 5000, 8000, |i| noisy(i, -9.8)).is_empty());
        assert_eq!(watch.current().unwrap().name, "upside_down");
        let told = changes(&mut watch, 8000, 12_000, |i| noisy(i, 9.8));
        assert_eq!(names(&told), ["over"]);
        let FaultChange::Over { lasted_s, .. } = told[0] else {
            panic!("{told:?}");
        };
        assert!(lasted_s > 8.0, "{lasted_s}");
    }

    #[test]
    fn a_bridge_that_repeats_one_frame_is_frozen() {
        let mut watch = FaultWatch::new(FullScale::default(), Mounting::default());
        let with_clock = |index: u32, device_time_us| ImuSample {
            device_time_us: Some(device_time_us),
            ..noisy(index, 9.8)
        };
        assert!(changes(&mut watch, 0, 2000, |i| with_clock(i, i * 1000)).is_empty());
        // The time of such samples hardly advances.
        let repeated = with_clock(5, 2_000_000);
        let told: Vec<FaultChange> = (0..1000_u32)
            .filter_map(|index| {
                let moment = Moment {
                    time_s: 2.0 + f64::from(index) * 1e-6,
                    arrival_s: 2.0 + f64::from(index) * 1e-3,
                };
                watch.take(moment, &repeated, &repeated, true)
            })
            .collect();
        let [FaultChange::Began(fault)] = told.as_slice() else {
            panic!("{told:?}");
        };
        assert_eq!(fault.name, "frozen");
        let told = changes(&mut watch, 3000, 4000, |i| with_clock(i, i * 1000));
        assert!(matches!(told[..], [FaultChange::Over { .. }]), "{told:?}");
    }
}
