//! When the robot started to walk.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{
    OrientationSeries, SettingError, sliding_range::SlidingRange,
    steady_drift::without_steady_drift_deg,
};

/// Parameters of the search for the start of motion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct MotionSettings {
    /// Length of the sliding window in which the fluctuation (maximum minus
    /// minimum) of each angle is taken.
    pub window_s: f64,
    /// Fluctuation of any angle that counts as moving. Half of it counts in a
    /// recording that never shows more: a healthy robot can walk that smoothly.
    pub threshold_deg: f64,
    /// The threshold is raised to this multiple of the standard deviation of the
    /// angles' noise, sample to sample.
    pub noise_factor: f64,
    /// For how long the motion must go on.
    pub confirmation_s: f64,
    /// Share of the confirmation time during which the robot must be moving. A
    /// healthy walk has quiet moments.
    pub moving_share: f64,
    /// Time from the gait's start to a body motion above the threshold: servo
    /// latency, backlash and the gentle first moments of the gait. Subtracted
    /// from the time of the first fluctuation.
    pub response_s: f64,
}

impl Default for MotionSettings {
    fn default() -> Self {
        Self {
            window_s: 0.04,
            threshold_deg: 0.04,
            noise_factor: 6.0,
            confirmation_s: 1.0,
            moving_share: 0.2,
            response_s: 0.07,
        }
    }
}

impl MotionSettings {
    /// Checks every number. A share, a factor or a response time of zero is valid: it counts
    /// for nothing.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        let check = SettingError::check::<f64>;
        check("window_s", self.window_s, 0.001..=10.0, "s")?;
        check("threshold_deg", self.threshold_deg, 1e-6..=360.0, "degrees")?;
        check("noise_factor", self.noise_factor, 0.0..=1000.0, "")?;
        check("confirmation_s", self.confirmation_s, 0.01..=600.0, "s")?;
        check("moving_share", self.moving_share, 0.0..=1.0, "")?;
        check("response_s", self.response_s, 0.0..=10.0, "s")
    }
}

/// The start of the walk in a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionStart {
    /// Estimated log time at which the gait started.
    pub start_s: f64,
    /// Whether the recording shows the robot standing before that. If not, it
    /// starts in mid-walk and `start_s` is its first sample.
    pub stood_before: bool,
}

/// The recording has no walk in it.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "no motion: roll, pitch and yaw never fluctuate by more than {threshold_deg:.3}° within {window_s} s for long enough"
)]
pub struct NoMotion {
    /// Smallest threshold tried, after allowing for the recording's noise.
    pub threshold_deg: f64,
    /// Length of the sliding window.
    pub window_s: f64,
}

impl MotionStart {
    /// Finds the first lasting motion of the body. Time stamps
    /// must increase.
    ///
    /// The method is the paper's sliding window, with a window short enough for the first
    /// motion of a healthy robot, whose angles stay within a degree. The drift of a biased
    /// gyroscope while the robot stands is removed first.
    ///
    /// # Errors
    /// [`NoMotion`] when there is none.
    pub fn find(
        recording: &OrientationSeries,
        settings: &MotionSettings,
    ) -> Result<Self, NoMotion> {
        let times_s = recording.times_s();
        let Fluctuation {
            deg: fluctuation_deg,
            smallest_deg,
            threshold_deg,
        } = Fluctuation::of(recording, settings);
        [threshold_deg, smallest_deg]
            .into_iter()
            .find_map(|threshold_deg| {
                first_sustained(times_s, &fluctuation_deg, threshold_deg, settings)
            })
            .map(|index| {
                let standing = times_s[index] - times_s[0];
                let stood_before = standing > settings.window_s + settings.response_s;
                Self {
                    start_s: if stood_before {
                        times_s[index] - settings.response_s
                    } else {
                        times_s[0]
                    },
                    stood_before,
                }
            })
            .ok_or(NoMotion {
                threshold_deg: smallest_deg,
                window_s: settings.window_s,
            })
    }
}

/// How much a body moves, sample by sample.
pub(crate) struct Fluctuation {
    /// The largest fluctuation of any angle within the window that ends at a sample.
    pub(crate) deg: Vec<f64>,
    /// What counts as moving in a recording that never shows more, after allowing for its noise.
    pub(crate) smallest_deg: f64,
    /// What counts as moving otherwise.
    threshold_deg: f64,
}

impl Fluctuation {
    /// Of a recording whose time stamps increase, without the drift of a biased gyroscope while the
    /// robot stands.
    pub(crate) fn of(recording: &OrientationSeries, settings: &MotionSettings) -> Self {
        let angles = recording.angles_rad();
        let noise_deg = [&angles.roll, &angles.pitch, &angles.yaw]
            .map(|samples| noise_deviation(samples))
            .into_iter()
            .fold(0.0, f64::max)
            .to_degrees();
        let above_noise = |threshold_deg: f64| threshold_deg.max(settings.noise_factor * noise_deg);
        let smallest_deg = above_noise(settings.threshold_deg / 2.0);
        let angles_deg = without_steady_drift_deg(recording, smallest_deg);
        let mut ranges = [(); 3].map(|()| SlidingRange::new(settings.window_s));
        let times_s = recording.times_s().iter().enumerate();
        let deg = times_s.map(|(index, &time_s)| {
            [&angles_deg.roll, &angles_deg.pitch, &angles_deg.yaw]
                .into_iter()
                .zip(&mut ranges)
                .map(|(samples, range)| range.push(time_s, samples[index]))
                .fold(0.0, f64::max)
        });
        Self {
            deg: deg.collect(),
            smallest_deg,
            threshold_deg: above_noise(settings.threshold_deg),
        }
    }
}

/// Standard deviation of the sample-to-sample noise on a smooth signal: the
/// median absolute second difference, scaled for white Gaussian noise. Motion
/// contributes little: its rate changes slowly from one sample to the next.
fn noise_deviation(samples: &[f64]) -> f64 {
    /// Median of |x| for a standard normal x.
    const MEDIAN_OF_NORMAL: f64 = 0.674_489_75;
    let mut differences: Vec<f64> = samples
        .windows(3)
        .map(|s| (s[0] - 2.0 * s[1] + s[2]).abs())
        .collect();
    if differences.is_empty() {
        return 0.0;
    }
    let middle = differences.len() / 2;
    let (_, median, _) = differences.select_nth_unstable_by(middle, f64::total_cmp);
    // A second difference of white noise has six times its variance.
    *median / MEDIAN_OF_NORMAL / 6.0_f64.sqrt()
}

/// Index of the first sample of a confirmed motion above the threshold.
fn first_sustained(
    times_s: &[f64],
    fluctuation_deg: &[f64],
    threshold_deg: f64,
    settings: &MotionSettings,
) -> Option<usize> {
    let moving: Vec<bool> = fluctuation_deg.iter().map(|f| *f > threshold_deg).collect();
    let mut end = 0;
    let mut moving_samples = 0;
    for (index, &now_moving) in moving.iter().enumerate() {
        while end < times_s.len() && times_s[end] < times_s[index] + settings.confirmation_s {
            moving_samples += usize::from(moving[end]);
            end += 1;
        }
        if end == times_s.len() {
            return None;
        }
        let share = moving_samples as f64 / (end - index) as f64;
        if now_moving && share >= settings.moving_share {
            return Some(index);
        }
        moving_samples -= usize::from(now_moving);
    }
    None
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use proptest::prelude::*;

    use super::*;
    use crate::Axes;

    /// Stands until `start_s`, then rocks; with noise of a fixed pattern.
    fn recording(start_s: f64, amplitude_deg: f64, noise_deg: f64) -> OrientationSeries {
        let times_s: Vec<f64> = (0..8000).map(|i| f64::from(i) / 970.0).collect();
        let roll = times_s
            .iter()
            .enumerate()
            .map(|(i, t)| {
                let noise = noise_deg * ((i * 7919) % 101) as f64 / 101.0;
                let walked_s = (t - start_s).max(0.0);
                (amplitude_deg * (TAU * walked_s).sin() + noise).to_radians()
            })
            .collect();
        let still = vec![0.0; times_s.len()];
        OrientationSeries::new(
            times_s,
            Axes {
                roll,
                pitch: still.clone(),
                yaw: still,
            },
        )
        .unwrap()
    }

    fn find(recording: &OrientationSeries) -> Result<MotionStart, NoMotion> {
        MotionStart::find(recording, &MotionSettings::default())
    }

    #[test]
    fn standing_is_no_motion() {
        assert!(find(&recording(100.0, 5.0, 0.02)).is_err());
        assert!(find(&recording(100.0, 5.0, 0.5)).is_err(), "loud noise");
        assert!(
            find(&recording(1.0, 20.0, 0.5)).is_ok(),
            "loud noise, then motion"
        );
    }

    #[test]
    fn a_single_knock_is_no_motion() {
        let quiet = recording(100.0, 0.0, 0.01);
        let mut angles = quiet.angles_rad().clone();
        angles.roll[3000..3050].fill(0.1);
        let knocked = OrientationSeries::new(quiet.times_s().to_vec(), angles).unwrap();
        assert!(find(&knocked).is_err());
    }

    #[test]
    fn a_recording_that_begins_in_mid_walk_says_so() {
        let start = find(&recording(0.0, 5.0, 0.01)).unwrap();
        assert!(!start.stood_before);
        assert_eq!(start.start_s, 0.0);
    }

    #[test]
    fn an_empty_recording_has_no_motion() {
        let empty = OrientationSeries::new(vec![], Axes::default()).unwrap();
        assert!(find(&empty).is_err());
    }

    proptest! {
        #[test]
        fn the_start_is_found_within_the_response_time(
            start_s in 0.5..5.0_f64,
            amplitude_deg in 1.0..20.0_f64,
            noise_deg in 0.0..0.03_f64,
        ) {
            let found = find(&recording(start_s, amplitude_deg, noise_deg)).unwrap();
            let response_s = MotionSettings::default().response_s;
            prop_assert!(found.stood_before);
            prop_assert!((found.start_s - start_s).abs() <= response_s, "{} for {start_s}", found.start_s);
        }
    }
}
