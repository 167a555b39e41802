//! The rows of a recording as the checks look at them.

use std::ops::Range;

use mlr_filter::{Axes, MotionSettings, MotionStart};
use nalgebra::{UnitQuaternion, Vector3};

use super::{Finding, FindingKind, Severity};
use crate::{Columns, Correction, ImuSample, OrientationSource, RawSeries, Recording};

/// A recording whose time stamps increase, and where in it the robot stands and walks.
pub(super) struct Rows<'a> {
    pub(super) times_s: &'a [f64],
    /// Roll, pitch and yaw that somebody else worked out; `None` where they were fused here.
    pub(super) angles_rad: Option<&'a Axes<Vec<f64>>>,
    /// Roll, pitch and yaw, whoever worked them out.
    pub(super) oriented_rad: &'a Axes<Vec<f64>>,
    pub(super) raw: Option<&'a RawSeries>,
    pub(super) columns: &'a Columns,
    /// The first sample of the walk; the number of samples where there is no walk.
    pub(super) walk_start: usize,
    /// Samples of the robot at rest before it walks; empty where the log shows none.
    pub(super) standing: Range<usize>,
    /// Samples from the first to the one at which a sensor failed.
    sound: Range<usize>,
}

/// A robot that is about to walk still stands so long before its walk is seen to start.
const MARGIN_S: f64 = 0.1;

impl<'a> Rows<'a> {
    pub(super) fn of(recording: &'a Recording, motion: &MotionSettings) -> Self {
        let times_s = recording.orientation.times_s();
        let start = MotionStart::find(&recording.orientation, motion).ok();
        let index_of = |time_s: f64| times_s.partition_point(|t| *t < time_s);
        let standing_end = match start {
            Some(start) if start.stood_before => index_of(start.start_s - MARGIN_S),
            Some(_) => 0,
            None => times_s.len(),
        };
        Self {
            times_s,
            angles_rad: (recording.source == OrientationSource::Recorded)
                .then(|| recording.orientation.angles_rad()),
            oriented_rad: recording.orientation.angles_rad(),
            raw: recording
                .raw
                .as_ref()
                .filter(|raw| raw.times_s.len() == times_s.len()),
            columns: &recording.columns,
            walk_start: start.map_or(times_s.len(), |start| index_of(start.start_s)),
            standing: 0..standing_end,
            sound: 0..times_s.len(),
        }
    }

    /// Leaves out what comes after a sensor has failed.
    pub(super) fn sound_until(&mut self, time_s: f64) {
        let end = self.times_s.partition_point(|t| *t < time_s);
        self.sound = 0..end;
        self.standing.end = self.standing.end.min(end);
    }

    /// Whether the log shows the robot walking.
    pub(super) fn has_walk(&self) -> bool {
        self.walk_start < self.times_s.len()
    }

    /// First and last time; zero for an empty recording.
    pub(super) fn span_s(&self) -> (f64, f64) {
        let first = self.times_s.first().copied().unwrap_or(0.0);
        (first, self.times_s.last().copied().unwrap_or(first))
    }

    /// The samples of the walk while the sensor works; those of the whole recording where
    /// there is no walk.
    pub(super) fn walking(&self) -> Range<usize> {
        let end = self.sound.end;
        if self.has_walk() {
            self.walk_start.min(end)..end
        } else {
            0..end
        }
    }

    /// Mean roll and pitch of the standing robot, where somebody else worked them out and the
    /// log shows it standing.
    pub(super) fn standing_roll_pitch_rad(&self) -> Option<[f64; 2]> {
        let angles = self.angles_rad?;
        let mean = |values: &[f64]| {
            let standing = values.get(self.standing.clone())?;
            let count = standing.len();
            (count > 0).then(|| standing.iter().sum::<f64>() / count as f64)
        };
        Some([mean(&angles.roll)?, mean(&angles.pitch)?])
    }

    /// A finding about the log from its first to its last row.
    pub(super) fn finding(
        &self,
        kind: FindingKind,
        severity: Severity,
        reason: String,
        cure: Option<String>,
    ) -> Finding {
        let (from_s, to_s) = self.span_s();
        Finding {
            kind,
            severity,
            from_s,
            to_s,
            reason,
            cure,
        }
    }

    /// The `--column` arguments that correct these quantities.
    pub(super) fn arguments(&self, keys: &[&str], correction: Correction) -> String {
        let arguments = keys
            .iter()
            .filter_map(|key| self.columns.corrected(key, correction));
        arguments.collect::<Vec<_>>().join(" ")
    }

    /// A row as a sensor would have sent it: only what was recorded, not what was fused.
    pub(super) fn sample(&self, index: usize) -> ImuSample {
        let vector = |vectors: fn(&RawSeries) -> &Vec<Vector3<f64>>| {
            self.raw.and_then(|raw| vectors(raw).get(index).copied())
        };
        ImuSample {
            acceleration_mps2: vector(|raw| &raw.accelerations_mps2),
            angular_rate_radps: vector(|raw| &raw.angular_rates_radps),
            orientation: self.angles_rad.map(|angles| {
                UnitQuaternion::from_euler_angles(
                    angles.roll[index],
                    angles.pitch[index],
                    angles.yaw[index],
                )
            }),
            ..ImuSample::default()
        }
    }

    /// Every recorded channel with its name.
    pub(super) fn channels(&self) -> Vec<Channel> {
        let mut channels = Vec::new();
        if let Some(angles) = self.angles_rad {
            for (name, values) in [
                ("roll", &angles.roll),
                ("pitch", &angles.pitch),
                ("yaw", &angles.yaw),
            ] {
                channels.push(Channel::new(name, values.clone()));
            }
        }
        if let Some(raw) = self.raw {
            for (axis, names) in [("ax", "gx"), ("ay", "gy"), ("az", "gz")]
                .iter()
                .enumerate()
            {
                let of = |vectors: &[Vector3<f64>]| vectors.iter().map(|v| v[axis]).collect();
                channels.push(Channel::new(names.0, of(&raw.accelerations_mps2)));
                channels.push(Channel::new(names.1, of(&raw.angular_rates_radps)));
            }
        }
        channels
    }
}

/// The values of one column, under the name that `--column` knows it by.
pub(super) struct Channel {
    pub(super) name: &'static str,
    pub(super) values: Vec<f64>,
}

impl Channel {
    fn new(name: &'static str, values: Vec<f64>) -> Self {
        Self { name, values }
    }
}
