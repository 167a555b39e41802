//! What the monitor asks for.

use mlr_ga::WalkStart;
use mlr_imu::Recording;
use mlr_residual::walk::Sensing;

use super::RequestNumber;
use crate::sensor_correction;

/// A stretch of the walk to identify or to explain.
#[derive(Debug, Clone)]
pub struct Request {
    /// Tells it from all others.
    pub number: RequestNumber,
    /// The stretch.
    pub stretch: WalkStretch,
}

/// A stretch of a walk.
#[derive(Debug, Clone)]
pub struct WalkStretch {
    /// What the sensor showed.
    pub recording: Recording,
    /// When the walk started, or a later cycle of its gait, if that was observed.
    pub walk_start: WalkStart,
    /// When the first step was seen.
    pub motion_start_s: Option<f64>,
    /// Where the stretch to compare begins.
    pub from_s: f64,
}

impl WalkStretch {
    /// The same stretch without what this sensor adds to the body's orientation. Its
    /// delay moves all times.
    #[must_use]
    pub fn corrected(self, sensing: &Sensing) -> Self {
        Self {
            recording: sensor_correction::corrected(self.recording, sensing),
            walk_start: match self.walk_start {
                WalkStart::ObservedAtS(time_s) => WalkStart::ObservedAtS(time_s - sensing.delay_s),
                other => other,
            },
            motion_start_s: self.motion_start_s.map(|time_s| time_s - sensing.delay_s),
            from_s: self.from_s - sensing.delay_s,
        }
    }
}

#[cfg(test)]
mod tests {
    use mlr_filter::{Axes, OrientationSeries};

    use super::*;

    #[test]
    fn a_late_sensor_moves_all_times_and_a_tilted_one_the_angles() {
        let times_s: Vec<f64> = (0..100).map(|i| f64::from(i) * 0.01).collect();
        let tilted = vec![0.1; times_s.len()];
        let recording = OrientationSeries::new(times_s, Axes::from_fn(|_| tilted.clone()));
        let stretch = WalkStretch {
            recording: recording.unwrap().into(),
            walk_start: WalkStart::ObservedAtS(0.2),
            motion_start_s: Some(0.2),
            from_s: 0.5,
        };
        let sensing = Sensing {
            misalignment_deg: [0.1_f64.to_degrees(), 0.0, 0.0],
            delay_s: 0.04,
            ..Sensing::default()
        };
        let corrected = stretch.corrected(&sensing);
        assert!((corrected.from_s - 0.46).abs() < 1e-9);
        let WalkStart::ObservedAtS(start_s) = corrected.walk_start else {
            panic!("{:?}", corrected.walk_start);
        };
        assert!((start_s - 0.16).abs() < 1e-9);
        let orientation = &corrected.recording.orientation;
        assert!((orientation.times_s()[0] + 0.04).abs() < 1e-9);
        assert!(orientation.angles_rad().roll[0].abs() < 1e-9);
        assert!((orientation.angles_rad().pitch[0] - 0.1).abs() < 1e-9);
    }
}
