//! The last seconds of what the sensor showed.

use std::{collections::VecDeque, ops::RangeInclusive};

use mlr_filter::{Axes, OrientationSeries};
use mlr_imu::{OrientationSource, RawSeries, Recording};

use crate::sensor::Reading;

/// Readings, none older than some seconds.
#[derive(Debug)]
pub(super) struct Recent {
    keep_s: f64,
    readings: VecDeque<Reading>,
}

/// A pause in the samples that spoils a stretch.
pub(super) const PAUSE_S: f64 = 0.2;

impl Recent {
    pub(super) fn new(keep_s: f64) -> Self {
        Self {
            keep_s,
            readings: VecDeque::new(),
        }
    }

    /// Takes the next one; says whether there was a pause before it.
    pub(super) fn push(&mut self, reading: Reading) -> bool {
        let now_s = reading.attitude.time_s;
        let paused = self
            .readings
            .back()
            .is_some_and(|last| now_s - last.attitude.time_s > PAUSE_S);
        self.readings.push_back(reading);
        while self
            .readings
            .front()
            .is_some_and(|first| first.attitude.time_s < now_s - self.keep_s)
        {
            self.readings.pop_front();
        }
        paused
    }

    /// Whether something is kept from so early on.
    pub(super) fn reaches_back_to(&self, time_s: f64) -> bool {
        self.readings
            .front()
            .is_some_and(|first| first.attitude.time_s <= time_s)
    }

    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        self.readings.clear();
    }

    /// Forgets what is older.
    pub(super) fn forget_before(&mut self, time_s: f64) {
        self.readings.retain(|past| past.attitude.time_s >= time_s);
    }

    /// The orientation that is kept from `from_s` on.
    pub(super) fn orientation(&self, from_s: f64) -> Option<OrientationSeries> {
        self.orientation_within(from_s..=f64::INFINITY)
    }

    fn orientation_within(&self, within_s: RangeInclusive<f64>) -> Option<OrientationSeries> {
        let mut times_s = Vec::new();
        let mut angles_rad = Axes::<Vec<f64>>::default();
        for Reading { attitude, .. } in self.within(within_s) {
            times_s.push(attitude.time_s);
            angles_rad.push(attitude.angles_rad);
        }
        OrientationSeries::new(times_s, angles_rad).ok()
    }

    /// What is kept of these times, the raw samples with it where each reading has them. `of` says
    /// what it is to show.
    pub(super) fn recording(
        &self,
        within_s: RangeInclusive<f64>,
        of: Stretch,
    ) -> Option<Recording> {
        let orientation = self.orientation_within(within_s.clone())?;
        let mut raw = RawSeries::default();
        let mut fused_here = false;
        for Reading { attitude, sample } in self.within(within_s) {
            fused_here |= sample.orientation.is_none();
            if let (Some(acceleration), Some(rate)) =
                (sample.acceleration_mps2, sample.angular_rate_radps)
            {
                raw.times_s.push(attitude.time_s);
                raw.accelerations_mps2.push(acceleration);
                raw.angular_rates_radps.push(rate);
            }
        }
        let is_complete = raw.times_s.len() == orientation.len();
        Some(Recording {
            raw: is_complete.then_some(raw),
            source: match (fused_here, of) {
                // The bias at rest is in the rates and not in what was fused of them here.
                (true, Stretch::InMidWalk) => OrientationSource::Fused,
                _ => OrientationSource::Recorded,
            },
            in_body_axes: true,
            ..Recording::from(orientation)
        })
    }

    fn within(&self, within_s: RangeInclusive<f64>) -> impl Iterator<Item = &Reading> {
        let kept = self.readings.iter();
        kept.filter(move |reading| within_s.contains(&reading.attitude.time_s))
    }
}

/// Which part of a walk is compared: only from its start are rates integrated in place of angles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stretch {
    /// From its first step, the robot at rest before it.
    FromTheStart,
    /// Later.
    InMidWalk,
}

#[cfg(test)]
mod tests {
    use mlr_imu::ImuSample;
    use nalgebra::{UnitQuaternion, Vector3};

    use super::*;
    use crate::attitude::Attitude;

    fn kept(sample: ImuSample, missing: Option<usize>) -> Recent {
        let mut recent = Recent::new(1.0);
        for index in 0..300_u32 {
            let without = missing == Some(index as usize);
            recent.push(Reading {
                attitude: Attitude {
                    time_s: f64::from(index) * 0.01,
                    angles_rad: Axes::default(),
                },
                sample: ImuSample {
                    angular_rate_radps: sample.angular_rate_radps.filter(|_| !without),
                    ..sample
                },
            });
        }
        recent
    }

    #[test]
    fn raw_samples_come_with_the_angles_that_the_device_made_of_them() {
        let raw = ImuSample {
            acceleration_mps2: Some(Vector3::z() * 9.81),
            angular_rate_radps: Some(Vector3::x()),
            ..ImuSample::default()
        };
        let with_angles = ImuSample {
            orientation: Some(UnitQuaternion::identity()),
            ..raw
        };
        let recording = |sample, missing, of| {
            let recent = kept(sample, missing);
            assert!(recent.reaches_back_to(2.0) && !recent.reaches_back_to(1.9));
            recent.recording(2.195..=2.805, of).unwrap()
        };
        for of in [Stretch::FromTheStart, Stretch::InMidWalk] {
            let recording = recording(with_angles, None, of);
            let raw = recording.raw_beside_angles().unwrap();
            assert_eq!(raw.times_s, recording.orientation.times_s());
            assert_eq!(raw.times_s.len(), 61);
        }
        // Those that were fused here count where rates are integrated from rest.
        let from_the_start = recording(raw, None, Stretch::FromTheStart);
        assert!(from_the_start.raw_beside_angles().is_some());
        let in_mid_walk = recording(raw, None, Stretch::InMidWalk);
        assert!(in_mid_walk.raw_beside_angles().is_none());
        let incomplete = recording(with_angles, Some(250), Stretch::InMidWalk);
        assert_eq!((incomplete.raw, incomplete.orientation.len()), (None, 61));
    }
}
