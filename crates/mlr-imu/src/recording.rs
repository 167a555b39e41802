mod from_columns;

use mlr_filter::{
    Axes, OrientationSeries, SeriesError, TimeStampFaults, increasing_times, unwrapped_rad,
};
use nalgebra::{UnitQuaternion, Vector3};

use crate::{Columns, ImuSample, Mounting, RawSeries};

/// What a log or a sensor says about a body's motion: its orientation over time, and the
/// raw samples of the same moments where they are known.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Roll, pitch and yaw, with the time stamps as recorded.
    pub orientation: OrientationSeries,
    /// Accelerations and rates, one for each sample of the orientation.
    pub raw: Option<RawSeries>,
    /// Where the orientation comes from.
    pub source: OrientationSource,
    /// Where its columns were found, for advice on how to read them otherwise.
    pub columns: Columns,
    /// Whether all of this is in the body's axes already, because whoever recorded it
    /// applied the mounting: [`Recording::mounted`] then changes nothing.
    pub in_body_axes: bool,
    /// What a person should know about how it was read.
    pub notes: Vec<String>,
}

/// Who made roll, pitch and yaw.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OrientationSource {
    /// The log holds them: a sensor's own filter, or another program.
    Recorded,
    /// Fused from the raw samples ([`RawSeries::fuse`]).
    Fused,
}

impl Recording {
    /// Drops samples whose time stamps are duplicated or run backwards, and says how many.
    pub fn with_increasing_times(mut self) -> (Self, TimeStampFaults) {
        let (kept, faults) = increasing_times(self.orientation.times_s());
        if faults.dropped() > 0 {
            self.orientation = self.orientation.picked(&kept);
            self.raw = self.raw.map(|raw| raw.picked(&kept));
        }
        (self, faults)
    }

    /// What was recorded before a log time.
    #[must_use]
    pub fn before(&self, end_s: f64) -> Self {
        let times_s = self.orientation.times_s().iter().enumerate();
        let is_before = times_s.filter(|(_, time_s)| **time_s < end_s);
        let kept: Vec<usize> = is_before.map(|(index, _)| index).collect();
        Self {
            orientation: self.orientation.picked(&kept),
            raw: self.raw.as_ref().map(|raw| raw.picked(&kept)),
            source: self.source,
            columns: self.columns.clone(),
            in_body_axes: self.in_body_axes,
            notes: Vec::new(),
        }
    }

    /// The raw samples that somebody else made roll, pitch and yaw from; `None` where they
    /// were fused here or are not known.
    pub fn raw_beside_angles(&self) -> Option<&RawSeries> {
        self.raw
            .as_ref()
            .filter(|_| self.source == OrientationSource::Recorded)
    }

    /// The recording as a calibrated sensor along the body's axes would have made it. An
    /// orientation that was fused from raw samples is fused anew from the calibrated ones,
    /// because the accelerometer's bias tilts it; a recorded one is turned. Yaw begins
    /// within half a turn of the recorded one and has no seams.
    ///
    /// The identity changes nothing, nor does any mounting where the recording is in the
    /// body's axes already.
    ///
    /// # Errors
    /// [`SeriesError`] when fusing the calibrated samples gives no finite numbers.
    pub fn mounted(self, mounting: &Mounting) -> Result<Self, SeriesError> {
        if self.in_body_axes || *mounting == Mounting::default() {
            return Ok(self);
        }
        let raw = self.raw.map(|raw| mounted_raw(raw, mounting));
        let orientation = match (&raw, self.source) {
            (Some(raw), OrientationSource::Fused) => raw.clone().fuse()?,
            _ => mounted_orientation(&self.orientation, mounting)?,
        };
        Ok(Self {
            orientation,
            raw,
            in_body_axes: true,
            ..self
        })
    }
}

fn mounted_raw(mut raw: RawSeries, mounting: &Mounting) -> RawSeries {
    let vectors = raw.accelerations_mps2.iter_mut();
    for (acceleration, rate) in vectors.zip(&mut raw.angular_rates_radps) {
        let in_body_axes = mounting.in_body_axes(&ImuSample {
            acceleration_mps2: Some(*acceleration),
            angular_rate_radps: Some(*rate),
            ..ImuSample::default()
        });
        let or_as_it_was = |vector: Option<Vector3<f64>>, was| vector.unwrap_or(was);
        *acceleration = or_as_it_was(in_body_axes.acceleration_mps2, *acceleration);
        *rate = or_as_it_was(in_body_axes.angular_rate_radps, *rate);
    }
    raw
}

fn mounted_orientation(
    recorded: &OrientationSeries,
    mounting: &Mounting,
) -> Result<OrientationSeries, SeriesError> {
    let angles = recorded.angles_rad();
    let mut mounted = Axes::<Vec<f64>>::default();
    let mut last_yaw = angles.yaw.first().copied().unwrap_or_default();
    for ((roll, pitch), yaw) in angles.roll.iter().zip(&angles.pitch).zip(&angles.yaw) {
        let sensor = UnitQuaternion::from_euler_angles(*roll, *pitch, *yaw);
        let sample = mounting.in_body_axes(&ImuSample {
            orientation: Some(sensor),
            ..ImuSample::default()
        });
        let (roll, pitch, yaw) = sample.orientation.unwrap_or(sensor).euler_angles();
        last_yaw = unwrapped_rad(last_yaw, yaw);
        mounted.push(Axes {
            roll,
            pitch,
            yaw: last_yaw,
        });
    }
    OrientationSeries::new(recorded.times_s().to_vec(), mounted)
}

impl From<OrientationSeries> for Recording {
    fn from(orientation: OrientationSeries) -> Self {
        Self {
            orientation,
            raw: None,
            source: OrientationSource::Recorded,
            columns: Columns::default(),
            in_body_axes: false,
            notes: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// What a sensor with this mounting records on a body that rocks while it turns by
    /// two and a half turns, and the body's own angles. The accelerometer is exact.
    fn rocking(mounting: &Mounting, source: OrientationSource) -> (Recording, Axes<Vec<f64>>) {
        let sensor_from_body = mounting.in_body_axes(&ImuSample {
            orientation: Some(UnitQuaternion::identity()),
            ..ImuSample::default()
        });
        let body_from_sensor = sensor_from_body.orientation.unwrap().inverse();
        let times_s: Vec<f64> = (0..2000).map(|i| f64::from(i) * 0.005).collect();
        let mut body = Axes::<Vec<f64>>::default();
        let mut recorded = Axes::<Vec<f64>>::default();
        let mut raw = RawSeries {
            times_s: times_s.clone(),
            ..RawSeries::default()
        };
        let mut last_yaw = 0.0;
        for &t in &times_s {
            let walked_s = (t - 1.0_f64).max(0.0);
            let (turned, rate) = match walked_s > 0.0 {
                true => (1.7 * walked_s, 1.7),
                false => (0.0, 0.0),
            };
            let roll = 0.1 * (3.0 * walked_s).sin().powi(2);
            let roll_rate = 0.3 * (6.0 * walked_s).sin();
            let attitude = UnitQuaternion::from_euler_angles(roll, 0.0, turned);
            body.push(Axes {
                roll,
                pitch: 0.0,
                yaw: turned,
            });
            let sensor = attitude * body_from_sensor;
            let (roll, pitch, yaw) = sensor.euler_angles();
            last_yaw = unwrapped_rad(last_yaw, yaw);
            recorded.push(Axes {
                roll,
                pitch,
                yaw: last_yaw,
            });
            let body_rate = Vector3::x() * roll_rate + attitude.inverse() * (Vector3::z() * rate);
            raw.accelerations_mps2
                .push(sensor.inverse() * (Vector3::z() * 9.81));
            raw.angular_rates_radps
                .push(body_from_sensor.inverse() * body_rate);
        }
        let orientation = match source {
            OrientationSource::Recorded => OrientationSeries::new(times_s, recorded).unwrap(),
            OrientationSource::Fused => raw.clone().fuse().unwrap(),
        };
        let recording = Recording {
            raw: Some(raw),
            source,
            ..Recording::from(orientation)
        };
        (recording, body)
    }

    fn turned(roll_deg: f64, pitch_deg: f64, yaw_deg: f64) -> Mounting {
        Mounting {
            roll_deg,
            pitch_deg,
            yaw_deg,
            ..Mounting::default()
        }
    }

    #[test]
    fn the_identity_returns_the_recording_bit_for_bit() {
        for source in [OrientationSource::Recorded, OrientationSource::Fused] {
            let (recording, _) = rocking(&turned(3.0, 4.0, 5.0), source);
            let same = recording.clone().mounted(&Mounting::default()).unwrap();
            assert_eq!(same, recording);
        }
    }

    #[test]
    fn a_mounting_is_applied_once() {
        let mounting = turned(0.0, 0.0, 90.0);
        let (recording, _) = rocking(&mounting, OrientationSource::Recorded);
        let once = recording.clone().mounted(&mounting).unwrap();
        assert_ne!(once.orientation, recording.orientation);
        assert_eq!(once.clone().mounted(&mounting).unwrap(), once);
    }

    #[test]
    fn a_fused_orientation_loses_the_tilt_of_the_accelerometers_bias() {
        let mounting = Mounting {
            accelerometer_bias_mps2: [1.0, 0.0, 0.0],
            ..turned(0.0, 0.0, 180.0)
        };
        let (mut recording, body) = rocking(&turned(0.0, 0.0, 180.0), OrientationSource::Fused);
        let raw = recording.raw.as_mut().unwrap();
        for acceleration in &mut raw.accelerations_mps2 {
            acceleration.x += 1.0;
        }
        recording.orientation = raw.clone().fuse().unwrap();
        let pitch_of = |recording: &Recording| recording.orientation.angles_rad().pitch[100];
        assert!(pitch_of(&recording).abs() > 0.05, "a tenth of g tilts it");
        let mounted = recording.mounted(&mounting).unwrap();
        assert!((pitch_of(&mounted) - body.pitch[100]).abs() < 0.005);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn angles_and_vectors_become_the_bodys(
            roll_deg in -180.0..180.0_f64,
            pitch_deg in -60.0..60.0_f64,
            yaw_deg in -180.0..180.0_f64,
        ) {
            let mounting = turned(roll_deg, pitch_deg, yaw_deg);
            let (recording, body) = rocking(&mounting, OrientationSource::Recorded);
            let mounted = recording.mounted(&mounting).unwrap();
            let ours = mounted.orientation.angles_rad();
            let raw = mounted.raw.unwrap();
            let yaw_zero = ours.yaw[0] - body.yaw[0];
            for index in 0..body.yaw.len() {
                prop_assert!((ours.roll[index] - body.roll[index]).abs() < 1e-9);
                prop_assert!((ours.pitch[index] - body.pitch[index]).abs() < 1e-9);
                // More than two full turns without a seam.
                let yaw = ours.yaw[index] - yaw_zero;
                prop_assert!((yaw - body.yaw[index]).abs() < 1e-9);
                let up = UnitQuaternion::from_euler_angles(body.roll[index], 0.0, body.yaw[index])
                    * raw.accelerations_mps2[index];
                prop_assert!((up - Vector3::z() * 9.81).norm() < 1e-9);
            }
        }
    }
}
