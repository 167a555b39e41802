//! A residual, split into what physics tells apart.

use std::f64::consts::TAU;

use mlr_filter::{Axes, Axis};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::WalkRecord;
use crate::statistics::{dominant_frequency, rms, runs_p_value, whiteness_p_value};

/// One axis of what a model leaves of a walk.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct AxisResidual {
    /// Mean while the robot stands, if the log shows it.
    pub standing_deg: Option<f64>,
    /// Mean while it walks.
    pub walking_deg: f64,
    /// Straight trend while it walks.
    pub drift_dps: f64,
    /// What repeats with the gait: its fundamental and harmonics.
    pub harmonics: Vec<Harmonic>,
    /// Mean while the legs of the gait's first half cycle swing, less that of the second
    /// half: what one group of legs does and the other does not.
    pub group_deg: f64,
    /// Slope over the sine of the heading, for a robot that turns.
    pub with_heading_deg: Option<f64>,
    /// Root mean square of what is left of all this.
    pub irregular_deg: f64,
    /// The part of that which is faster than about three hertz: no walking body swings so
    /// out of step with its gait.
    pub fast_deg: f64,
    /// Strongest oscillation of what is left.
    pub irregular_hz: Option<f64>,
    /// Its amplitude.
    pub irregular_amplitude_deg: Option<f64>,
    /// Probability that white noise is as correlated as what is left (Ljung and Box).
    pub whiteness_p_value: f64,
    /// Probability that independent errors change sign as rarely or as often (Wald and
    /// Wolfowitz).
    pub independence_p_value: f64,
}

/// A part of the residual at a multiple of the gait's frequency.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Harmonic {
    /// Its frequency.
    pub frequency_hz: f64,
    /// Its amplitude.
    pub amplitude_deg: f64,
    /// Gait phase of its crest, as a share of its own period.
    pub phase: f64,
}

/// Harmonics that are told apart at 25 samples per second.
const HARMONICS: usize = 8;
/// A mean over so many samples passes what is slower than about three hertz.
const SLOW_SAMPLES: usize = 5;
/// A robot that has turned by this much tells what depends on its heading.
const TURNED_DEG: f64 = 20.0;

/// Splits what is left of each axis over the walk.
pub(crate) fn decompose(
    record: &WalkRecord,
    residual_deg: &Axes<Vec<f64>>,
    gait_period_s: f64,
) -> Axes<AxisResidual> {
    let axes = residual_deg.as_ref();
    axes.map(|axis, residual| of_axis(record, axis, residual, gait_period_s))
}

fn of_axis(
    record: &WalkRecord,
    axis: Axis,
    residual_deg: &[f64],
    gait_period_s: f64,
) -> AxisResidual {
    let walking = record.fit().start..record.unseen().end.min(residual_deg.len());
    let standing = &residual_deg[record.standing()];
    let walk = &residual_deg[walking.clone()];
    let times_s: Vec<f64> = record.times_s()[walking.clone()]
        .iter()
        .map(|time_s| time_s - record.start_s())
        .collect();
    let middle_s = times_s.iter().sum::<f64>() / times_s.len().max(1) as f64;
    let yaw_deg = &record.measured_deg().yaw[walking];
    let heading = |index: usize| (yaw_deg[index] - yaw_deg[0]).to_radians();
    let most_rad = (0..yaw_deg.len())
        .map(|i| heading(i).abs())
        .fold(0.0, f64::max);
    let turns = axis != Axis::Yaw && most_rad.to_degrees() > TURNED_DEG;
    let mut columns: Vec<Box<dyn Fn(usize) -> f64>> = vec![
        Box::new(|_| 1.0),
        Box::new(|index| times_s[index] - middle_s),
    ];
    for k in 1..=HARMONICS {
        let rate = TAU * k as f64 / gait_period_s;
        columns.push(Box::new({
            let times_s = &times_s;
            move |index| (rate * times_s[index]).cos()
        }));
        columns.push(Box::new({
            let times_s = &times_s;
            move |index| (rate * times_s[index]).sin()
        }));
    }
    if turns {
        columns.push(Box::new(|index| heading(index).sin()));
    }
    let (sizes, left) = regress(walk, &columns);
    let harmonics = (1..=HARMONICS).map(|k| {
        let (cosine, sine) = (sizes[2 * k], sizes[2 * k + 1]);
        Harmonic {
            frequency_hz: k as f64 / gait_period_s,
            amplitude_deg: cosine.hypot(sine),
            phase: (sine.atan2(cosine) / TAU).rem_euclid(1.0),
        }
    });
    let in_first_half = |time_s: f64| (time_s / gait_period_s).rem_euclid(1.0) < 0.5;
    let mean_where = |wanted: bool| {
        let chosen = times_s.iter().zip(walk);
        let chosen = chosen.filter(|(time_s, _)| in_first_half(**time_s) == wanted);
        let (sum, count) = chosen.fold((0.0, 0), |(sum, count), (_, r)| (sum + r, count + 1));
        sum / f64::from(count.max(1))
    };
    let irregular = dominant_frequency(&left, WalkRecord::PERIOD_S);
    AxisResidual {
        standing_deg: (!standing.is_empty())
            .then(|| standing.iter().sum::<f64>() / standing.len() as f64),
        walking_deg: sizes[0],
        drift_dps: sizes[1],
        harmonics: harmonics.collect(),
        group_deg: mean_where(true) - mean_where(false),
        with_heading_deg: turns.then(|| sizes[sizes.len() - 1]),
        irregular_deg: rms(&left),
        fast_deg: rms(&fast_part(&left)),
        irregular_hz: irregular.map(|(frequency_hz, _)| frequency_hz),
        irregular_amplitude_deg: irregular.map(|(_, amplitude)| amplitude),
        whiteness_p_value: whiteness_p_value(&left),
        independence_p_value: runs_p_value(&left),
    }
}

impl AxisResidual {
    /// Root mean square of all that repeats with the gait.
    pub fn locked_to_gait_deg(&self) -> f64 {
        let squares = self.harmonics.iter().map(|h| h.amplitude_deg.powi(2) / 2.0);
        squares.sum::<f64>().sqrt()
    }

    /// The strongest harmonic.
    pub fn strongest_harmonic(&self) -> Option<&Harmonic> {
        let by_size = |a: &&Harmonic, b: &&Harmonic| a.amplitude_deg.total_cmp(&b.amplitude_deg);
        self.harmonics.iter().max_by(by_size)
    }
}

/// What is left of values without their means over [`SLOW_SAMPLES`].
fn fast_part(values: &[f64]) -> Vec<f64> {
    let half = SLOW_SAMPLES / 2;
    let around = |index: usize| {
        let stretch = &values[index.saturating_sub(half)..(index + half + 1).min(values.len())];
        stretch.iter().sum::<f64>() / stretch.len() as f64
    };
    (0..values.len())
        .map(|index| values[index] - around(index))
        .collect()
}

/// Size of each column in the values by least squares, and what is left.
fn regress(values: &[f64], columns: &[Box<dyn Fn(usize) -> f64 + '_>]) -> (Vec<f64>, Vec<f64>) {
    let design = DMatrix::from_fn(values.len(), columns.len(), |row, column| {
        columns[column](row)
    });
    let transposed = design.transpose();
    let mut normal = &transposed * &design;
    for k in 0..columns.len() {
        // Two columns alike share what is theirs.
        normal[(k, k)] += 1e-9 * values.len() as f64;
    }
    let target = DVector::from_column_slice(values);
    let Some(factors) = normal.cholesky() else {
        return (vec![0.0; columns.len()], values.to_vec());
    };
    let sizes = factors.solve(&(transposed * &target));
    let left = target - design * &sizes;
    (
        sizes.iter().copied().collect(),
        left.iter().copied().collect(),
    )
}

#[cfg(test)]
mod tests {
    use mlr_filter::OrientationSeries;

    use super::*;

    /// Stands for 2 s and walks for 12 s; roll is made of what the test says.
    fn split(roll: impl Fn(f64) -> f64) -> AxisResidual {
        let times_s: Vec<f64> = (0..1400).map(|i| f64::from(i) * 0.01).collect();
        let angles_rad = Axes {
            roll: times_s.iter().map(|t| roll(t - 2.0).to_radians()).collect(),
            pitch: vec![0.0; times_s.len()],
            yaw: vec![0.0; times_s.len()],
        };
        let recording = OrientationSeries::new(times_s, angles_rad).unwrap();
        let record = WalkRecord::new(&recording, 2.0, true, 2.0, None).unwrap();
        decompose(&record, record.measured_deg(), 1.0).roll
    }

    #[test]
    fn each_part_is_found_in_its_place() {
        let walk = |t: f64| {
            let gait = 0.4 * (TAU * 2.0 * (t - 0.1)).cos();
            if t < 0.0 {
                0.7
            } else {
                1.5 + 0.05 * t + gait + 0.2 * (TAU * 3.37 * t).sin()
            }
        };
        let found = split(walk);
        assert!(
            (found.standing_deg.unwrap() - 0.7).abs() < 0.01,
            "{found:?}"
        );
        assert!((found.walking_deg - 1.8).abs() < 0.05, "{found:?}");
        assert!((found.drift_dps - 0.05).abs() < 0.005, "{found:?}");
        let harmonic = found.strongest_harmonic().unwrap();
        assert_eq!(harmonic.frequency_hz, 2.0);
        assert!((harmonic.amplitude_deg - 0.4).abs() < 0.03, "{harmonic:?}");
        assert!((harmonic.phase - 0.2).abs() < 0.02, "{harmonic:?}");
        assert!(
            (found.irregular_hz.unwrap() - 3.37).abs() < 0.1,
            "{found:?}"
        );
        assert!((found.irregular_amplitude_deg.unwrap() - 0.2).abs() < 0.04);
        assert!(found.whiteness_p_value < 1e-6);
    }

    #[test]
    fn what_one_group_of_legs_does_is_told_from_the_other() {
        let found = split(|t| f64::from(u8::from(t.rem_euclid(1.0) < 0.5)));
        assert!((found.group_deg - 1.0).abs() < 0.1, "{found:?}");
        let none = split(|t| (TAU * 2.0 * t).sin());
        assert!(none.group_deg.abs() < 0.05, "{none:?}");
    }
}
