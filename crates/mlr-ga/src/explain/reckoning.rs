//! Dead-reckoned orientation from raw rates, where it agrees with the recorded one.

use std::ops::Range;

use mlr_filter::{MovingMean, OrientationSeries};
use mlr_imu::RawSeries;

/// Time between two compared orientations.
const STEP_S: f64 = 0.04;
/// Dead-reckoned and recorded rotations agree if the standard deviation of their difference is
/// below this share of that of the recorded rotations, plus [`MOST_OFF_RAD`].
const MOST_OFF: f64 = 0.5;
/// Allowance for bodies that rock little: errors that accelerations cause in an attitude filter.
const MOST_OFF_RAD: f64 = 6e-4;

/// Roll, pitch and yaw integrated from the rates of `raw` alone from the start of `rest_s` on,
/// if they agree with the `recording`, which another filter made from the same samples. They
/// do not where raw samples are too slow for the shocks of a walk, or along other axes.
pub(super) fn dead_reckoned(
    raw: &RawSeries,
    recording: &OrientationSeries,
    rest_s: Range<f64>,
) -> Option<OrientationSeries> {
    let reckoned = raw.dead_reckoned(rest_s)?;
    turn_alike(&reckoned, recording).then_some(reckoned)
}

/// Compares the rotations in roll and pitch over [`STEP_S`]: corrections of a filter towards
/// gravity are slow, and a bias adds the same to each.
fn turn_alike(reckoned: &OrientationSeries, recording: &OrientationSeries) -> bool {
    let ends = reckoned.times_s().first().zip(reckoned.times_s().last());
    let Some((first_s, last_s)) = ends else {
        return false;
    };
    let looks = ((last_s - first_s) / STEP_S) as usize;
    let turns = |series: &OrientationSeries| -> Vec<[f64; 2]> {
        let means = MovingMean::new(series);
        let looks: Vec<[f64; 2]> = (0..looks)
            .map(|look| means.around(first_s + look as f64 * STEP_S, STEP_S / 2.0))
            .map(|angles| [angles.roll, angles.pitch])
            .collect();
        let pairs = looks.windows(2);
        pairs
            .map(|pair| [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]])
            .collect()
    };
    let (reckoned, recorded) = (turns(reckoned), turns(recording));
    (0..2).all(|axis| {
        let both = reckoned.iter().zip(&recorded);
        let off_rad: Vec<f64> = both.map(|(a, b)| a[axis] - b[axis]).collect();
        let turns_rad: Vec<f64> = recorded.iter().map(|turn| turn[axis]).collect();
        deviation(&off_rad) < MOST_OFF * deviation(&turns_rad) + MOST_OFF_RAD
    })
}

fn deviation(values: &[f64]) -> f64 {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares = values.iter().map(|value| (value - mean).powi(2));
    (squares.sum::<f64>() / count).sqrt()
}

#[cfg(test)]
mod tests {
    use mlr_filter::Axes;
    use nalgebra::Vector3;

    use super::*;

    /// A sensor that stands for 2 s and then rolls to and fro, and the roll.
    fn rolling() -> (RawSeries, OrientationSeries) {
        let mut raw = RawSeries::default();
        let mut roll = Vec::new();
        for index in 0..1600 {
            let time_s = f64::from(index) * 0.005;
            let moving_s = (time_s - 2.0).max(0.0);
            let rate = if moving_s > 0.0 {
                0.5 * (5.0 * moving_s).sin()
            } else {
                0.0
            };
            raw.times_s.push(time_s);
            raw.angular_rates_radps.push(Vector3::x() * rate);
            raw.accelerations_mps2.push(Vector3::z() * 9.81);
            roll.push(0.1 * (1.0 - (5.0 * moving_s).cos()));
        }
        let still = vec![0.0; roll.len()];
        let angles = Axes {
            roll,
            pitch: still.clone(),
            yaw: still,
        };
        let recording = OrientationSeries::new(raw.times_s.clone(), angles).unwrap();
        (raw, recording)
    }

    #[test]
    fn rates_that_turn_as_the_recording_are_believed() {
        let (raw, recording) = rolling();
        let reckoned = dead_reckoned(&raw, &recording, 0.0..1.9).unwrap();
        let error = reckoned.angles_rad().roll[1500] - recording.angles_rad().roll[1500];
        assert!(error.abs() < 1e-3, "{error}");
    }

    #[test]
    fn a_bias_is_no_reason_to_doubt() {
        let (mut raw, recording) = rolling();
        let rates = raw.angular_rates_radps.iter_mut();
        rates.for_each(|rate| *rate += Vector3::new(0.08, -0.06, 0.05));
        assert!(dead_reckoned(&raw, &recording, 0.0..1.9).is_some());
    }

    #[test]
    fn rates_about_other_axes_and_slow_ones_are_not() {
        let (mut raw, recording) = rolling();
        let turned = RawSeries {
            angular_rates_radps: raw.angular_rates_radps.iter().map(|r| r.yzx()).collect(),
            ..raw.clone()
        };
        assert_eq!(dead_reckoned(&turned, &recording, 0.0..1.9), None);
        let slow: Vec<usize> = (0..raw.times_s.len()).step_by(20).collect();
        raw.times_s = slow.iter().map(|i| raw.times_s[*i]).collect();
        raw.angular_rates_radps = slow.iter().map(|i| raw.angular_rates_radps[*i]).collect();
        raw.accelerations_mps2 = slow.iter().map(|i| raw.accelerations_mps2[*i]).collect();
        assert_eq!(dead_reckoned(&raw, &recording, 0.0..1.9), None);
    }
}
