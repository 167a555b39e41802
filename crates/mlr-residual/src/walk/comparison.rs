//! How far a predicted walk is from the measured one.

use mlr_filter::{Axes, SettingError};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::{
    Prediction, Trace, WalkRecord,
    usual::{Difference, difference},
};

/// What errors of a predicted walk weigh.
///
/// They are not noise: they come from what the model lacks and repeat with the gait, so
/// that a stretch holds few independent ones, and their size is not known beforehand.
/// Marginalised over that size, n errors of mean square S cost n · ln(S).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ErrorWeights {
    /// Independent errors of roll, pitch and yaw in a stretch of several cycles.
    pub independent_errors: [f64; 3],
    /// Errors below this size say nothing: what no model of a walk gets right.
    pub floor_deg: [f64; 3],
    /// The same where a sensor's own filter made the angles: it takes some of the body's
    /// accelerations for tilt.
    pub filtered_floor_deg: [f64; 3],
    /// The same for roll and pitch of the standing robot.
    pub standing_deg: f64,
    /// The same for rates at rest.
    pub rest_rate_dps: f64,
}

impl ErrorWeights {
    /// Checks every number.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        let each = SettingError::check_each;
        let errors = &self.independent_errors;
        each("independent_errors", errors, 0.01..=1000.0, "")?;
        let (floor_deg, filtered_deg) = (&self.floor_deg, &self.filtered_floor_deg);
        each("floor_deg", floor_deg, 1e-6..=45.0, "degrees")?;
        each("filtered_floor_deg", filtered_deg, 1e-6..=45.0, "degrees")?;
        let (standing_deg, rest_dps) = (self.standing_deg, self.rest_rate_dps);
        SettingError::check("standing_deg", standing_deg, 1e-6..=45.0, "degrees")?;
        SettingError::check("rest_rate_dps", rest_dps, 1e-6..=100.0, "°/s")
    }

    fn floor_of(&self, record: &WalkRecord) -> [f64; 3] {
        if record.is_dead_reckoned() {
            self.floor_deg
        } else {
            self.filtered_floor_deg
        }
    }
}

impl Default for ErrorWeights {
    fn default() -> Self {
        Self {
            independent_errors: [5.0, 5.0, 3.0],
            floor_deg: [0.04, 0.04, 0.1],
            filtered_floor_deg: [0.06, 0.06, 0.12],
            standing_deg: 0.05,
            rest_rate_dps: 0.03,
        }
    }
}

/// Compares predictions with a record, the usual differences fitted along.
#[derive(Debug, Clone)]
pub(crate) struct Comparison<'a> {
    pub(crate) record: &'a WalkRecord,
    pub(crate) weights: ErrorWeights,
    usual: Vec<Trace>,
    /// How much of each usual difference the predictions have already, in standard
    /// deviations.
    pub(crate) there: Vec<f64>,
    /// Linear functions of standing angles that must come out right: each a weight per
    /// standing sample of one axis, in units of its deviation.
    standing: Vec<(usize, Vec<f64>)>,
}

/// A predicted walk laid over the record as well as the usual differences allow.
#[derive(Debug, Clone)]
pub(crate) struct Settled {
    /// Size of each usual difference in standard deviations; after them the extra traces.
    pub(crate) sizes: Vec<f64>,
    /// Measured less predicted, degrees, over all samples that were predicted.
    pub(crate) residual_deg: Axes<Vec<f64>>,
    /// Mean square on the fitted stretch.
    pub(crate) fit_deg2: [f64; 3],
    /// Twice the negative logarithm of likelihood times prior, up to a constant.
    pub(crate) cost: f64,
    /// Covariance of the sizes.
    pub(crate) covariance: DMatrix<f64>,
}

/// Rounds of weighing the axes by what is left of them.
const ROUNDS: usize = 4;
/// Damping that only keeps the equations solvable.
const FREE: f64 = 1e-9;

impl<'a> Comparison<'a> {
    pub(crate) fn new(
        record: &'a WalkRecord,
        weights: ErrorWeights,
        usual: Vec<Trace>,
        there: Vec<f64>,
    ) -> Self {
        Self {
            record,
            weights,
            usual,
            there,
            standing: standing_functions(record, &weights),
        }
    }

    /// The same with another division of the record into what is fitted and what is not.
    pub(crate) fn with_record(&self, record: &'a WalkRecord) -> Self {
        Self {
            record,
            ..self.clone()
        }
    }

    /// The same without any usual difference but the zeros of yaw and time: the model as
    /// described.
    pub(crate) fn as_described(&self) -> Comparison<'a> {
        Comparison {
            record: self.record,
            weights: self.weights,
            usual: Difference::ALL
                .into_iter()
                .zip(&self.usual)
                .filter(|(difference, _)| difference.is_of_zeros())
                .map(|(_, trace)| trace.clone())
                .collect(),
            there: Vec::new(),
            standing: Vec::new(),
        }
    }

    /// Fits the usual differences, and as much of the `extra` traces as it takes, to what
    /// the prediction leaves on the fitted stretch. Extra traces cost nothing.
    pub(crate) fn settle(&self, predicted: &Prediction, extra: &[Trace]) -> Settled {
        self.settle_damped(predicted, extra, FREE)
    }

    /// The same, where each extra trace costs `damping` times its squared size: what the
    /// record hardly tells does not run away.
    pub(crate) fn settle_damped(
        &self,
        predicted: &Prediction,
        extra: &[Trace],
        damping: f64,
    ) -> Settled {
        let residual = difference(self.record.measured_deg(), &predicted.angles_deg);
        let rest_residual = self.record.rest_rate_dps().map(|rest| {
            [0, 1, 2].map(|axis| {
                (rest[axis] - predicted.rest_rate_dps[axis]) / self.weights.rest_rate_dps
            })
        });
        let traces: Vec<&Trace> = self.usual.iter().chain(extra).collect();
        let count = traces.len();
        let axes = residual.as_ref().into_array();
        let fit = self.record.fit();
        let floor2 = self
            .weights
            .floor_of(self.record)
            .map(|floor| floor * floor);
        let mut left = axes.map(|axis| axis.clone());
        let mut square = left.each_ref().map(|axis| mean_square(&axis[fit.clone()]));
        let mut sizes = DVector::zeros(count);
        let mut covariance = DMatrix::zeros(count, count);
        for _ in 0..ROUNDS {
            let mut normal = DMatrix::zeros(count, count);
            let mut gradient = DVector::zeros(count);
            for k in 0..count {
                normal[(k, k)] += if k < self.usual.len() { 1.0 } else { damping };
                gradient[k] -= self.there.get(k).copied().unwrap_or(0.0);
            }
            for axis in 0..3 {
                let weight = self.weights.independent_errors[axis]
                    / (fit.len() as f64 * (square[axis] + floor2[axis]));
                let columns: Vec<&[f64]> = traces
                    .iter()
                    .map(|trace| &trace.of_axis(axis)[fit.clone()])
                    .collect();
                add_rows(
                    &mut normal,
                    &mut gradient,
                    &columns,
                    &axes[axis][fit.clone()],
                    weight,
                );
            }
            for (axis, function) in &self.standing {
                let columns: Vec<f64> = traces
                    .iter()
                    .map(|trace| dot(function, trace.of_axis(*axis)))
                    .collect();
                let value = dot(function, axes[*axis]);
                add_row(&mut normal, &mut gradient, &columns, value);
            }
            if let Some(rest) = rest_residual {
                for (axis, value) in rest.into_iter().enumerate() {
                    let columns: Vec<f64> = traces
                        .iter()
                        .map(|trace| trace.rest_rate_dps[axis] / self.weights.rest_rate_dps)
                        .collect();
                    add_row(&mut normal, &mut gradient, &columns, value);
                }
            }
            let Some(factors) = normal.cholesky() else {
                break;
            };
            sizes = factors.solve(&gradient);
            covariance = factors.inverse();
            for axis in 0..3 {
                left[axis].clone_from(axes[axis]);
                for (trace, size) in traces.iter().zip(sizes.iter()) {
                    for (value, change) in left[axis].iter_mut().zip(trace.of_axis(axis)) {
                        *value -= size * change;
                    }
                }
            }
            square = left.each_ref().map(|axis| mean_square(&axis[fit.clone()]));
        }
        let of_errors = self.cost_of(square);
        let there = self.there.iter().copied().chain(std::iter::repeat(0.0));
        let of_usual: f64 = sizes
            .iter()
            .take(self.usual.len())
            .zip(there)
            .map(|(size, there)| (there + size).powi(2))
            .sum();
        let of_standing: f64 = self
            .standing
            .iter()
            .map(|(axis, function)| dot(function, &left[*axis]).powi(2))
            .sum();
        let of_rest: f64 = rest_residual.map_or(0.0, |rest| {
            let left = (0..3).map(|axis| {
                let added: f64 = traces
                    .iter()
                    .zip(sizes.iter())
                    .map(|(trace, size)| size * trace.rest_rate_dps[axis])
                    .sum();
                rest[axis] - added / self.weights.rest_rate_dps
            });
            left.map(|value| value * value).sum()
        });
        let [roll, pitch, yaw] = left;
        Settled {
            sizes: sizes.iter().copied().collect(),
            residual_deg: Axes { roll, pitch, yaw },
            fit_deg2: square,
            cost: of_errors + of_usual + of_standing + of_rest,
            covariance,
        }
    }

    /// What errors of these mean squares cost.
    pub(crate) fn cost_of(&self, mean_square_deg2: [f64; 3]) -> f64 {
        let floor_deg = self.weights.floor_of(self.record);
        (0..3)
            .map(|axis| {
                let floor = floor_deg[axis];
                let square = mean_square_deg2[axis] + floor * floor;
                self.weights.independent_errors[axis] * square.ln()
            })
            .sum()
    }

    /// How many usual differences there are.
    pub(crate) fn usual(&self) -> usize {
        self.usual.len()
    }
}

/// A walk that is predicted worse than this on one of its axes answers to its parameters in
/// jumps.
const ROUGH_DEG: [f64; 3] = [0.5, 0.5, 1.0];

/// A walk that is predicted worse than this nearly tips over, or slips at random: a change of
/// anything may help by chance.
const WILD_DEG: [f64; 3] = [1.5, 1.5, 2.0];

/// Whether a prediction that leaves these mean squares is worse than `limits_deg` on any axis.
fn exceeds(mean_square_deg2: [f64; 3], limits_deg: [f64; 3]) -> bool {
    let mut axes = mean_square_deg2.into_iter().zip(limits_deg);
    axes.any(|(square_deg2, limit_deg)| square_deg2 > limit_deg * limit_deg)
}

/// Whether a prediction that leaves these mean squares is so far off that a change of anything
/// may help by chance.
pub(crate) fn is_wild(mean_square_deg2: [f64; 3]) -> bool {
    exceeds(mean_square_deg2, WILD_DEG)
}

/// Whether a prediction is so far off that straight lines lead nowhere.
pub(crate) fn is_rough(mean_square_deg2: [f64; 3]) -> bool {
    exceeds(mean_square_deg2, ROUGH_DEG)
}

impl Settled {
    /// See [`is_rough`].
    pub(crate) fn is_rough(&self) -> bool {
        is_rough(self.fit_deg2)
    }

    /// Mean square of each axis on a stretch.
    pub(crate) fn mean_square_deg2(&self, stretch: std::ops::Range<usize>) -> [f64; 3] {
        let axes = self.residual_deg.as_ref().into_array();
        axes.map(|axis| mean_square(&axis[stretch.clone()]))
    }
}

impl Trace {
    fn of_axis(&self, axis: usize) -> &[f64] {
        match axis {
            0 => &self.angles_deg.roll,
            1 => &self.angles_deg.pitch,
            _ => &self.angles_deg.yaw,
        }
    }
}

/// Mean roll and pitch, and the slope of the yaw where rates at rest are not known.
fn standing_functions(record: &WalkRecord, weights: &ErrorWeights) -> Vec<(usize, Vec<f64>)> {
    let standing = record.standing();
    let n = standing.len();
    if n < 5 {
        return Vec::new();
    }
    let mean = vec![1.0 / (n as f64 * weights.standing_deg); n];
    let mut functions = vec![(0, mean.clone()), (1, mean)];
    if record.rest_rate_dps().is_none() {
        let middle = (n as f64 - 1.0) / 2.0;
        let line: Vec<f64> = (0..n)
            .map(|index| (index as f64 - middle) * WalkRecord::PERIOD_S)
            .collect();
        let length2: f64 = line.iter().map(|x| x * x).sum();
        // A short stand tells the rate badly.
        let deviation_dps = weights.rest_rate_dps.max(0.05 / length2.sqrt());
        let slope = line.iter().map(|x| x / (length2 * deviation_dps)).collect();
        functions.push((2, slope));
    }
    functions
}

fn add_rows(
    normal: &mut DMatrix<f64>,
    gradient: &mut DVector<f64>,
    columns: &[&[f64]],
    values: &[f64],
    weight: f64,
) {
    for (k, column) in columns.iter().enumerate() {
        gradient[k] += weight * dot(column, values);
        for (l, other) in columns.iter().enumerate().skip(k) {
            let product = weight * dot(column, other);
            normal[(k, l)] += product;
            if l != k {
                normal[(l, k)] += product;
            }
        }
    }
}

fn add_row(normal: &mut DMatrix<f64>, gradient: &mut DVector<f64>, columns: &[f64], value: f64) {
    let columns: Vec<&[f64]> = columns.iter().map(std::slice::from_ref).collect();
    add_rows(normal, gradient, &columns, &[value], 1.0);
}

/// Over as many as the shorter one has.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub(crate) fn mean_square(values: &[f64]) -> f64 {
    values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use mlr_filter::OrientationSeries;

    use super::*;

    fn record() -> WalkRecord {
        let times_s: Vec<f64> = (0..1200).map(|i| f64::from(i) * 0.01).collect();
        let swing = times_s
            .iter()
            .map(|t| 0.02 * (6.0 * (t - 2.0).max(0.0)).sin());
        let swing: Vec<f64> = swing.collect();
        let recording = OrientationSeries::new(times_s, Axes::from_fn(|_| swing.clone())).unwrap();
        WalkRecord::new(&recording, 2.0, true, 2.0, Some([0.4, 0.0, 0.0])).unwrap()
    }

    /// What was measured, and the rates at rest.
    fn perfect(record: &WalkRecord) -> Prediction {
        Prediction {
            angles_deg: record.measured_deg().clone(),
            rest_rate_dps: [0.4, 0.0, 0.0],
        }
    }

    /// The same with two degrees of roll too few.
    fn two_degrees_off(record: &WalkRecord) -> Prediction {
        let mut predicted = perfect(record);
        let roll_deg = predicted.angles_deg.roll.iter_mut();
        roll_deg.for_each(|roll| *roll -= 2.0);
        predicted
    }

    /// A trace that adds one degree of roll wherever the robot is.
    fn one_degree_of_roll(samples: usize, bias_dps: f64) -> Trace {
        Trace {
            angles_deg: Axes {
                roll: vec![1.0; samples],
                pitch: vec![0.0; samples],
                yaw: vec![0.0; samples],
            },
            rest_rate_dps: [bias_dps, 0.0, 0.0],
        }
    }

    #[test]
    fn a_usual_difference_is_fitted_at_the_price_of_its_size() {
        let record = record();
        let samples = record.times_s().len();
        let tilt = vec![one_degree_of_roll(samples, 0.0)];
        let comparison = Comparison::new(&record, ErrorWeights::default(), tilt, vec![0.0]);
        let exact = comparison.settle(&perfect(&record), &[]);
        let off = comparison.settle(&two_degrees_off(&record), &[]);
        assert!((off.sizes[0] - 2.0).abs() < 0.05, "{:?}", off.sizes);
        assert!(
            (off.cost - exact.cost - 4.0).abs() < 0.5,
            "{} {}",
            off.cost,
            exact.cost
        );
        assert!(off.mean_square_deg2(record.unseen())[0] < 0.01);
    }

    #[test]
    fn an_extra_trace_is_free() {
        let record = record();
        let comparison = Comparison::new(&record, ErrorWeights::default(), Vec::new(), Vec::new());
        let exact = comparison.settle(&perfect(&record), &[]);
        let extra = [one_degree_of_roll(record.times_s().len(), 0.0)];
        let off = comparison.settle(&two_degrees_off(&record), &extra);
        assert!((off.sizes[0] - 2.0).abs() < 1e-3, "{:?}", off.sizes);
        assert!((off.cost - exact.cost).abs() < 0.1);
    }

    #[test]
    fn rates_at_rest_count_beside_the_angles() {
        let record = record();
        let comparison = Comparison::new(&record, ErrorWeights::default(), Vec::new(), Vec::new());
        let predicted = perfect(&record);
        let with = comparison.settle(&predicted, &[]).cost;
        let unbiased = Prediction {
            rest_rate_dps: [0.0; 3],
            ..predicted
        };
        let without = comparison.settle(&unbiased, &[]).cost;
        let deviations = 0.4 / ErrorWeights::default().rest_rate_dps;
        let price = deviations * deviations;
        assert!((without - with - price).abs() < 0.1, "{without} {with}");
    }
}
