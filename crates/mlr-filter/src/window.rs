//! A stretch of a recording on an even time grid.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{Axes, OrientationSeries, SettingError};

/// The stretch of time to compare.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// Time stamp of the first sample.
    pub start_s: f64,
    /// Length.
    pub duration_s: f64,
}

/// What a recording must offer within a window.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct SamplingLimits {
    /// Lowest mean sampling rate. The default lets a sensor of nominally 50 Hz pass whose
    /// clock or driver makes it 48 Hz, and is more than four times the default cutoff of
    /// the filter.
    pub min_rate_hz: f64,
    /// Longest time without a sample; within it the signal is bridged by a
    /// straight line.
    pub max_gap_s: f64,
}

impl Default for SamplingLimits {
    fn default() -> Self {
        Self {
            min_rate_hz: 45.0,
            max_gap_s: 0.25,
        }
    }
}

impl SamplingLimits {
    /// Checks every number.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        SettingError::check("min_rate_hz", self.min_rate_hz, 1.0..=100_000.0, "Hz")?;
        SettingError::check("max_gap_s", self.max_gap_s, 0.001..=10.0, "s")
    }
}

/// Why a recording has no answer in a window.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum WindowError {
    /// The recording does not cover the window.
    #[error(
        "too short: the {needed_s:.2} s from {start_s:.2} s on are needed, the log ends at {end_s:.2} s"
    )]
    TooShort {
        /// Where the window starts.
        start_s: f64,
        /// Its length.
        needed_s: f64,
        /// Last time stamp of the recording.
        end_s: f64,
    },
    /// Too few samples.
    #[error(
        "sampled too slowly: {rate_hz:.1} Hz between {start_s:.2} and {end_s:.2} s, at least {min_rate_hz:.0} Hz are needed"
    )]
    TooSlow {
        /// Mean rate found.
        rate_hz: f64,
        /// Start of the window.
        start_s: f64,
        /// End of the window.
        end_s: f64,
        /// Rate needed.
        min_rate_hz: f64,
    },
    /// Too long without a sample.
    #[error(
        "samples are missing from {from_s:.3} to {to_s:.3} s, longer than the {max_gap_s:.2} s that can be bridged"
    )]
    Gap {
        /// Last sample before the gap.
        from_s: f64,
        /// First sample after it.
        to_s: f64,
        /// Longest gap allowed.
        max_gap_s: f64,
    },
}

/// Roll, pitch and yaw in radians at an even rate, relative to their values at
/// the start: the common initial conditions of measured and simulated signals.
#[derive(Debug, Clone, PartialEq)]
pub struct EvenSamples {
    rate_hz: f64,
    angles_rad: Axes<Vec<f64>>,
}

impl EvenSamples {
    /// Samples per second.
    pub fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// The angles; the first sample of each axis is zero.
    pub fn angles_rad(&self) -> &Axes<Vec<f64>> {
        &self.angles_rad
    }
}

impl Window {
    /// Cuts this window out of a recording whose time stamps increase, and
    /// interpolates it linearly onto an even grid of about the recording's own
    /// rate.
    ///
    /// The grid has `n = rate · duration` points and spans `[start, start +
    /// duration)`: one period of the discrete Fourier transform.
    ///
    /// # Errors
    /// [`WindowError`] when the recording does not cover the window well enough.
    pub fn cut(
        &self,
        recording: &OrientationSeries,
        limits: &SamplingLimits,
    ) -> Result<EvenSamples, WindowError> {
        let times_s = recording.times_s();
        let (from, to) = self.covering(times_s)?;
        let covered = &times_s[from..=to];
        let intervals = (to - from) as f64;
        let rate_hz = intervals / (covered[covered.len() - 1] - covered[0]);
        if rate_hz < limits.min_rate_hz {
            return Err(WindowError::TooSlow {
                rate_hz,
                start_s: self.start_s,
                end_s: self.start_s + self.duration_s,
                min_rate_hz: limits.min_rate_hz,
            });
        }
        if let Some(gap) = covered
            .windows(2)
            .find(|pair| pair[1] - pair[0] > limits.max_gap_s)
        {
            return Err(WindowError::Gap {
                from_s: gap[0],
                to_s: gap[1],
                max_gap_s: limits.max_gap_s,
            });
        }
        let points = (rate_hz * self.duration_s).round().max(1.0);
        let step_s = self.duration_s / points;
        let grid_s: Vec<f64> = (0..points as usize)
            .map(|i| self.start_s + i as f64 * step_s)
            .collect();
        let angles_rad = recording.angles_rad().as_ref().map(|_, samples| {
            let mut even = interpolate(covered, &samples[from..=to], &grid_s);
            let start = even[0];
            even.iter_mut().for_each(|angle| *angle -= start);
            even
        });
        Ok(EvenSamples {
            rate_hz: points / self.duration_s,
            angles_rad,
        })
    }

    /// Indices of the last sample at or before the start and of the first at or
    /// after the end of the last grid interval.
    fn covering(&self, times_s: &[f64]) -> Result<(usize, usize), WindowError> {
        let end_s = self.start_s + self.duration_s;
        let too_short = || WindowError::TooShort {
            start_s: self.start_s,
            needed_s: self.duration_s,
            end_s: times_s.last().copied().unwrap_or(0.0),
        };
        // A recording at an even rate ends one interval before `end_s`.
        let tolerance_s = match times_s {
            [.., before, last] => (last - before) * (1.0 + 1e-6),
            _ => return Err(too_short()),
        };
        let from = times_s
            .partition_point(|&t| t <= self.start_s + 1e-9)
            .checked_sub(1)
            .ok_or_else(too_short)?;
        let to = times_s.partition_point(|&t| t < end_s - 1e-9);
        if to < times_s.len() {
            Ok((from, to))
        } else if times_s[to - 1] + tolerance_s >= end_s && to - 1 > from {
            Ok((from, to - 1))
        } else {
            Err(too_short())
        }
    }
}

/// Linear interpolation at increasing `grid_s`; constant beyond the ends.
fn interpolate(times_s: &[f64], samples: &[f64], grid_s: &[f64]) -> Vec<f64> {
    let mut right = 1;
    grid_s
        .iter()
        .map(|&t| {
            while right + 1 < times_s.len() && times_s[right] < t {
                right += 1;
            }
            let left = right - 1;
            let share = (t - times_s[left]) / (times_s[right] - times_s[left]);
            samples[left] + share.clamp(0.0, 1.0) * (samples[right] - samples[left])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const WINDOW: Window = Window {
        start_s: 0.5,
        duration_s: 2.0,
    };

    fn recording(times_s: Vec<f64>, signal: impl Fn(f64) -> f64) -> OrientationSeries {
        let samples: Vec<f64> = times_s.iter().map(|&t| signal(t)).collect();
        OrientationSeries::new(times_s, Axes::from_fn(|_| samples.clone())).unwrap()
    }

    fn even_times(rate_hz: f64, duration_s: f64) -> Vec<f64> {
        (0..=(rate_hz * duration_s) as usize)
            .map(|i| i as f64 / rate_hz)
            .collect()
    }

    #[test]
    fn an_even_recording_keeps_its_rate_and_samples() {
        let series = recording(even_times(250.0, 4.0), |t| t * t);
        let even = WINDOW.cut(&series, &SamplingLimits::default()).unwrap();
        assert!((even.rate_hz() - 250.0).abs() < 1e-9);
        for (i, angle) in even.angles_rad().roll.iter().enumerate() {
            let t = 0.5 + i as f64 / 250.0;
            assert!((angle - (t * t - 0.25)).abs() < 1e-9);
        }
    }

    /// How much of a sine survives the cut, the samples falling anywhere between the grid's.
    fn carried_share(rate_hz: f64, sine_hz: f64) -> f64 {
        let limits = SamplingLimits {
            min_rate_hz: 1.0,
            ..SamplingLimits::default()
        };
        let mean_square = |samples: &[f64]| {
            let mean = samples.iter().sum::<f64>() / samples.len() as f64;
            let squares = samples.iter().map(|x| (x - mean) * (x - mean));
            squares.sum::<f64>() / samples.len() as f64
        };
        let shifts = (0..10).map(|tenth| f64::from(tenth) / 10.0 / rate_hz);
        let shares = shifts.map(|shift_s| {
            let times_s = even_times(rate_hz, 4.0)
                .iter()
                .map(|t| t + shift_s)
                .collect();
            let sine = recording(times_s, |t| (std::f64::consts::TAU * sine_hz * t).sin());
            let even = WINDOW.cut(&sine, &limits).unwrap();
            (mean_square(&even.angles_rad().roll) / 0.5).sqrt()
        });
        shares.sum::<f64>() / 10.0
    }

    #[test]
    fn the_lowest_rate_carries_the_gait_and_nearly_as_much_of_the_cutoff_as_fifty_hertz() {
        let lowest_hz = SamplingLimits::default().min_rate_hz;
        // The gait's own frequencies, at which the robot's damage shows.
        for sine_hz in [1.0, 2.0, 3.0] {
            assert!(carried_share(lowest_hz, sine_hz) > 0.97, "{sine_hz} Hz");
        }
        let at_cutoff = |rate_hz| carried_share(rate_hz, 10.0);
        assert!(at_cutoff(lowest_hz) > 0.8, "{}", at_cutoff(lowest_hz));
        assert!(at_cutoff(50.0) - at_cutoff(lowest_hz) < 0.05);
        // The control: half of that rate does not carry it.
        assert!(at_cutoff(lowest_hz / 2.0) < 0.6);
    }

    #[test]
    fn a_nominal_fifty_hertz_that_is_a_little_less_will_do() {
        let cut = |rate_hz| {
            let series = recording(even_times(rate_hz, 4.0), |t| t);
            WINDOW.cut(&series, &SamplingLimits::default())
        };
        assert!(cut(48.8).is_ok());
        let message = cut(44.0).unwrap_err().to_string();
        assert!(message.contains("at least 45 Hz"), "{message}");
    }

    #[test]
    fn a_recording_that_ends_with_the_window_is_long_enough() {
        let mut times_s = even_times(250.0, 2.5);
        times_s.pop();
        assert!(
            WINDOW
                .cut(&recording(times_s, |t| t), &SamplingLimits::default())
                .is_ok()
        );
    }

    #[test]
    fn what_is_missing_is_said() {
        let limits = SamplingLimits::default();
        let short = recording(even_times(250.0, 2.0), |t| t);
        assert!(matches!(
            WINDOW.cut(&short, &limits),
            Err(WindowError::TooShort { .. })
        ));
        let slow = recording(even_times(5.0, 4.0), |t| t);
        assert!(matches!(
            WINDOW.cut(&slow, &limits),
            Err(WindowError::TooSlow { .. })
        ));
        let mut times_s = even_times(250.0, 4.0);
        times_s.retain(|t| !(1.0..1.3).contains(t));
        let gap = WINDOW.cut(&recording(times_s, |t| t), &limits);
        assert!(matches!(gap, Err(WindowError::Gap { .. })), "{gap:?}");
        let empty = OrientationSeries::new(vec![], Axes::default()).unwrap();
        assert!(matches!(
            WINDOW.cut(&empty, &limits),
            Err(WindowError::TooShort { .. })
        ));
    }

    proptest! {
        #[test]
        fn jitter_does_not_move_a_straight_line(
            steps_s in prop::collection::vec(0.000_95..0.001_55_f64, 3000..3001),
            slope in -2.0..2.0_f64,
        ) {
            let times_s: Vec<f64> = steps_s.iter().scan(0.0, |t, step| { *t += step; Some(*t) }).collect();
            let even = WINDOW
                .cut(&recording(times_s, |t| slope * t + 0.3), &SamplingLimits::default())
                .unwrap();
            for (i, angle) in even.angles_rad().yaw.iter().enumerate() {
                prop_assert!((angle - slope * i as f64 / even.rate_hz()).abs() < 1e-9);
            }
        }
    }
}
