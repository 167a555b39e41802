//! Moving means of orientation.

use crate::{Axes, OrientationSeries};

/// Means of roll, pitch and yaw over a short interval around any time: a finite low pass
/// without ringing at the edges. The interval may start and end between samples.
///
/// Between samples the angles are interpolated linearly. Means over an interval of
/// width w pass half the power at 0.44 / w.
///
/// ```
/// use mlr_filter::{Axes, MovingMean, OrientationSeries};
///
/// let times_s: Vec<f64> = (0..100).map(|i| f64::from(i) * 0.01).collect();
/// let ramp = Axes::from_fn(|_| times_s.clone());
/// let series = OrientationSeries::new(times_s, ramp)?;
/// let mean = MovingMean::new(&series).around(0.505, 0.02);
/// assert!((mean.roll - 0.505).abs() < 1e-12);
/// # Ok::<(), mlr_filter::SeriesError>(())
/// ```
#[derive(Debug, Clone)]
pub struct MovingMean<'a> {
    series: &'a OrientationSeries,
    /// Integral of each angle from the first sample to each sample.
    integrals: Axes<Vec<f64>>,
}

impl<'a> MovingMean<'a> {
    /// Prepares means of a series whose time stamps increase.
    pub fn new(series: &'a OrientationSeries) -> Self {
        let times_s = series.times_s();
        let integrals = series.angles_rad().as_ref().map(|_, angles| {
            let mut total = 0.0;
            let mut integral = Vec::with_capacity(angles.len());
            integral.push(0.0);
            for (time, angle) in times_s.windows(2).zip(angles.windows(2)) {
                total += 0.5 * (angle[0] + angle[1]) * (time[1] - time[0]);
                integral.push(total);
            }
            integral
        });
        Self { series, integrals }
    }

    /// The mean over `half_width_s` to both sides of `time_s`, of what the series
    /// covers of it. Beyond its ends the series is held constant.
    pub fn around(&self, time_s: f64, half_width_s: f64) -> Axes<f64> {
        let times_s = self.series.times_s();
        let (Some(&first_s), Some(&last_s)) = (times_s.first(), times_s.last()) else {
            return Axes::default();
        };
        let from_s = (time_s - half_width_s).clamp(first_s, last_s);
        let to_s = (time_s + half_width_s).clamp(first_s, last_s);
        let (from, to) = (self.locate(from_s), self.locate(to_s));
        let angles = self.series.angles_rad().as_ref();
        let width_s = to_s - from_s;
        if width_s <= 0.0 {
            return angles.map(|_, angles| value_at(times_s, angles, from, from_s));
        }
        let integrals = self.integrals.as_ref().into_array();
        let means = [0, 1, 2].map(|axis| {
            let angles = self.series.angles_rad().as_ref().into_array()[axis];
            let at = |index, time_s| integral_at(times_s, angles, integrals[axis], index, time_s);
            (at(to, to_s) - at(from, from_s)) / width_s
        });
        Axes {
            roll: means[0],
            pitch: means[1],
            yaw: means[2],
        }
    }

    /// Index of the last sample not after `time_s`.
    fn locate(&self, time_s: f64) -> usize {
        let after = self.series.times_s().partition_point(|&t| t <= time_s);
        after.saturating_sub(1)
    }
}

fn value_at(times_s: &[f64], angles: &[f64], index: usize, time_s: f64) -> f64 {
    let (Some(&next), Some(&next_s)) = (angles.get(index + 1), times_s.get(index + 1)) else {
        return angles[index];
    };
    let share = (time_s - times_s[index]) / (next_s - times_s[index]);
    angles[index] + share * (next - angles[index])
}

fn integral_at(
    times_s: &[f64],
    angles: &[f64],
    integral: &[f64],
    index: usize,
    time_s: f64,
) -> f64 {
    let value = value_at(times_s, angles, index, time_s);
    integral[index] + 0.5 * (angles[index] + value) * (time_s - times_s[index])
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use proptest::prelude::*;

    use super::*;

    fn series(times_s: Vec<f64>, f: impl Fn(f64) -> f64) -> OrientationSeries {
        let angles = times_s.iter().map(|t| f(*t)).collect::<Vec<f64>>();
        OrientationSeries::new(times_s, Axes::from_fn(|_| angles.clone())).unwrap()
    }

    #[test]
    fn a_sinusoid_is_damped_as_a_mean_damps_it() {
        let times_s: Vec<f64> = (0..4000).map(|i| f64::from(i) * 0.001).collect();
        let (frequency_hz, half_width_s) = (5.0, 0.03);
        let series = series(times_s, |t| (TAU * frequency_hz * t).sin());
        let x = TAU * frequency_hz * half_width_s;
        let gain = x.sin() / x;
        let means = MovingMean::new(&series);
        for t in [1.0, 1.0333, 2.07] {
            let expected = gain * (TAU * frequency_hz * t).sin();
            assert!((means.around(t, half_width_s).pitch - expected).abs() < 2e-4);
        }
    }

    #[test]
    fn the_ends_go_on() {
        let series = series(vec![0.0, 1.0], |t| t);
        let means = MovingMean::new(&series);
        assert_eq!(means.around(-5.0, 0.1).yaw, 0.0);
        assert_eq!(means.around(5.0, 0.1).yaw, 1.0);
        assert!((means.around(0.0, 0.1).yaw - 0.05).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn a_straight_line_stays_one_however_uneven_the_samples(
            steps_s in prop::collection::vec(0.001..0.05_f64, 20..60),
            slope in -3.0..3.0_f64,
            share in 0.3..0.7_f64,
        ) {
            let times_s: Vec<f64> = steps_s
                .iter()
                .scan(0.0, |t, step| { *t += step; Some(*t) })
                .collect();
            let (first, last) = (times_s[0], times_s[times_s.len() - 1]);
            let series = series(times_s, |t| slope * t);
            let at = first + share * (last - first);
            let mean = MovingMean::new(&series).around(at, 0.2 * (last - first)).roll;
            prop_assert!((mean - slope * at).abs() < 1e-9);
        }
    }
}
