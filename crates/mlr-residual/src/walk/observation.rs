//! What is compared with a prediction, and how errors of the comparison are whitened.

use std::ops::Range;

use nalgebra::{Cholesky, DMatrix, DVector, DVectorView, Dyn};

use super::{
    Discrepancy, Prediction, WalkRecord,
    discrepancy::{Compared, Correlations, Spread, Unknown, turned_s},
};

/// The samples that hypotheses are judged by.
///
/// Errors are vectors: roll, pitch and yaw of every sample that counts, in degrees, then the rates
/// at rest about x, y and z in degrees per second.
#[derive(Debug, Clone)]
pub(crate) struct Observation<'a> {
    pub(crate) record: &'a WalkRecord,
    indices: Vec<usize>,
    correlations: Correlations,
    rest_rate_dps: f64,
    /// Power of the likelihood.
    power: f64,
    /// The angle turned at each sample by a robot that turns by one degree per second.
    turned_s: Vec<f64>,
}

/// Groups of errors that have a scale in common: roll and pitch, yaw, rates at rest.
pub(crate) const GROUPS: usize = 3;

/// Makes errors independent and of unit variance: multiplies by the inverse of the Cholesky factor
/// of their covariance.
#[derive(Debug, Clone)]
pub(crate) struct Whitening {
    factors: [DMatrix<f64>; 3],
    rest_rate_dps: f64,
    /// Logarithm of the determinant of the covariance.
    ln_determinant: f64,
    /// Factors by which the discrepancy of each group may exceed what is usual, and the logarithms
    /// of their probabilities.
    scales: [Vec<(f64, f64)>; GROUPS],
    power: f64,
}

/// Every so many samples of the standing robot count: it moves slowly, if at all.
const STANDING_STRIDE: usize = 10;
/// Every so many samples of the walking robot count: the sixth harmonic of a gait of one second
/// is the last that a walk shows.
const WALKING_STRIDE: usize = 2;

impl<'a> Observation<'a> {
    pub(crate) fn new(record: &'a WalkRecord, discrepancy: &Discrepancy, period_s: f64) -> Self {
        Self::of(record, discrepancy, period_s, record.fit())
    }

    /// The same of the first half of the walk alone.
    pub(crate) fn of_beginning(
        record: &'a WalkRecord,
        discrepancy: &Discrepancy,
        period_s: f64,
    ) -> Self {
        let walk = record.fit();
        let half = walk.start..walk.start + walk.len() / 2;
        Self::of(record, discrepancy, period_s, half)
    }

    /// The same of the whole walk, of which nothing is left to measure errors.
    pub(crate) fn of_whole(
        record: &'a WalkRecord,
        discrepancy: &Discrepancy,
        period_s: f64,
    ) -> Self {
        Self::of(record, discrepancy, period_s, record.walking())
    }

    fn of(
        record: &'a WalkRecord,
        discrepancy: &Discrepancy,
        period_s: f64,
        walk: Range<usize>,
    ) -> Self {
        let standing = record.standing().step_by(STANDING_STRIDE);
        let walking = walk.step_by(WALKING_STRIDE);
        let indices: Vec<usize> = standing.chain(walking).collect();
        let walked_s: Vec<f64> = indices
            .iter()
            .map(|k| record.times_s()[*k] - record.start_s())
            .collect();
        Self {
            correlations: Correlations::new(discrepancy, record, &indices, period_s),
            rest_rate_dps: discrepancy.rest_rate_dps,
            power: discrepancy.power,
            turned_s: turned_s(&walked_s, period_s),
            record,
            indices,
        }
    }

    /// Share of robots whose walk the engine misses as something unknown would make it.
    pub(crate) fn missed_share(&self, spread: Spread) -> f64 {
        self.correlations.missed_share(spread)
    }

    /// Power of the likelihood.
    pub(crate) fn power(&self) -> f64 {
        self.power
    }

    /// How many numbers an error has.
    pub(crate) fn len(&self) -> usize {
        3 * self.indices.len() + 3
    }

    /// Log time of each sample that counts.
    pub(crate) fn times_s(&self) -> Vec<f64> {
        self.indices
            .iter()
            .map(|k| self.record.times_s()[*k])
            .collect()
    }

    /// How many samples of each axis count.
    pub(crate) fn samples_of_an_axis(&self) -> usize {
        self.indices.len()
    }

    /// One past the last sample that counts.
    pub(crate) fn samples(&self) -> usize {
        self.indices.last().map_or(0, |last| last + 1)
    }

    /// Measured less predicted.
    pub(crate) fn residual(&self, predicted: &Prediction) -> DVector<f64> {
        let rest_rate_dps = self.record.rest_rate_dps();
        let measured = Prediction {
            angles_deg: self.record.measured_deg().clone(),
            rest_rate_dps: rest_rate_dps.unwrap_or(predicted.rest_rate_dps),
        };
        self.change(predicted, &measured)
    }

    /// What leads from one prediction to another. Rates at rest count where they are known.
    pub(crate) fn change(&self, from: &Prediction, to: &Prediction) -> DVector<f64> {
        let from_axes = from.angles_deg.as_ref().into_array();
        let to_axes = to.angles_deg.as_ref().into_array();
        let angles = (0..3).flat_map(|axis| {
            let (from, to) = (from_axes[axis], to_axes[axis]);
            self.indices.iter().map(move |k| to[*k] - from[*k])
        });
        let known = self.record.rest_rate_dps().is_some();
        let rest = (0..3).map(|axis| match known {
            true => to.rest_rate_dps[axis] - from.rest_rate_dps[axis],
            false => 0.0,
        });
        DVector::from_iterator(self.len(), angles.chain(rest))
    }

    /// How far a walk spreads by changes that are independent of each other.
    pub(crate) fn spread<'c>(
        &self,
        changes: impl IntoIterator<Item = DVectorView<'c, f64>>,
    ) -> Spread {
        let n = self.indices.len();
        let first = self
            .indices
            .partition_point(|k| *k < self.record.fit().start);
        let turned_s = DVector::from_column_slice(&self.turned_s[first..]);
        let turned_s = turned_s.add_scalar(-turned_s.mean());
        let lever = turned_s.norm_squared().max(1e-9);
        let (mut tilt, mut turning) = (0.0, 0.0);
        for change in changes {
            for axis in 0..2 {
                tilt += change.rows(axis * n + first, n - first).variance();
            }
            let yaw = change.rows(2 * n + first, n - first);
            turning += (turned_s.dot(&yaw) / lever).powi(2);
        }
        Spread {
            tilt_deg: tilt.sqrt(),
            turning_dps: turning.sqrt(),
        }
    }

    /// Covariance of errors where robots of one make spread so far.
    #[cfg(test)]
    pub(crate) fn covariance(&self, spread: Spread) -> DMatrix<f64> {
        let n = self.indices.len();
        let mut whole = DMatrix::zeros(self.len(), self.len());
        for axis in 0..3 {
            let covariance = self.correlations.covariance(axis, spread, Compared::Walk);
            whole
                .view_mut((axis * n, axis * n), (n, n))
                .copy_from(&covariance);
        }
        for k in 3 * n..self.len() {
            whole[(k, k)] = self.rest_rate_dps * self.rest_rate_dps;
        }
        whole
    }

    /// For errors of what is compared where robots of one make spread so far; `None` where their covariance
    /// is not positive definite.
    pub(crate) fn whitening(&self, spread: Spread, compared: Compared<'_>) -> Option<Whitening> {
        let covariance = |axis| self.correlations.covariance(axis, spread, compared);
        Whitening::new(
            [0, 1, 2].map(covariance),
            self.rest_rate_dps,
            self.correlations.scales(spread),
            self.power,
        )
    }

    /// For the same errors where something unknown acts: in each way that it may.
    pub(crate) fn with_unknown(&self, usual: &Whitening) -> Vec<Whitening> {
        let known = usual.factors.each_ref().map(|f| f * f.transpose());
        let ways = Unknown::ways().filter_map(|unknown| {
            let covariance = |axis: usize| match self.correlations.of_unknown(axis, unknown) {
                Some(added) => &known[axis] + added,
                None => known[axis].clone(),
            };
            Whitening::new(
                [0, 1, 2].map(covariance),
                usual.rest_rate_dps,
                usual.scales.clone(),
                usual.power,
            )
        });
        ways.collect()
    }
}

impl Whitening {
    /// For errors with these covariances of roll, pitch and yaw; `None` where one is not positive definite.
    fn new(
        covariances: [DMatrix<f64>; 3],
        rest_rate_dps: f64,
        scales: [Vec<(f64, f64)>; GROUPS],
        power: f64,
    ) -> Option<Self> {
        let mut ln_determinant = 6.0 * rest_rate_dps.ln();
        let mut factor = |covariance: DMatrix<f64>| -> Option<DMatrix<f64>> {
            let factor = Cholesky::<f64, Dyn>::new(covariance)?.unpack();
            ln_determinant += 2.0 * factor.diagonal().map(f64::ln).sum();
            Some(factor)
        };
        let [roll, pitch, yaw] = covariances;
        Some(Self {
            factors: [factor(roll)?, factor(pitch)?, factor(yaw)?],
            rest_rate_dps,
            ln_determinant,
            scales,
            power,
        })
    }

    /// Whitens each column.
    pub(crate) fn apply(&self, errors: &DMatrix<f64>) -> DMatrix<f64> {
        let mut whitened = errors.clone();
        let mut first = 0;
        for factor in &self.factors {
            let n = factor.nrows();
            let solved = factor.solve_lower_triangular_mut(&mut whitened.rows_mut(first, n));
            debug_assert!(solved, "a Cholesky factor has no zero on its diagonal");
            first += n;
        }
        let mut rest = whitened.rows_mut(first, errors.nrows() - first);
        rest /= self.rest_rate_dps;
        whitened
    }

    /// Whitens one error.
    pub(crate) fn apply_to(&self, error: &DVector<f64>) -> DVector<f64> {
        let column = DMatrix::from_column_slice(error.len(), 1, error.as_slice());
        DVector::from_column_slice(self.apply(&column).as_slice())
    }

    /// Sum of squares of a whitened error, group by group.
    pub(crate) fn squares(&self, error: &DVector<f64>) -> [f64; GROUPS] {
        let whitened = self.apply_to(error);
        self.groups(error.len())
            .map(|rows| whitened.rows_range(rows).norm_squared())
    }

    /// The rows of each group in an error of so many.
    pub(crate) fn groups(&self, rows: usize) -> [Range<usize>; GROUPS] {
        let n = self.factors[0].nrows();
        [0..2 * n, 2 * n..3 * n, 3 * n..rows]
    }

    /// Precisions of errors of usual scale.
    pub(crate) fn usual_precisions(&self) -> [f64; GROUPS] {
        [self.power; GROUPS]
    }

    /// Logarithm of the density of errors with these whitened sums of squares, their scales
    /// integrated out, and of each group the mean of one over the square of its scale: its mean
    /// precision.
    pub(crate) fn ln_density(&self, squares: [f64; GROUPS], rows: usize) -> (f64, [f64; GROUPS]) {
        let counts = self.groups(rows).map(|rows| rows.len() as f64);
        let mut ln_density = -0.5 * self.power * self.ln_determinant;
        let precisions = std::array::from_fn(|group| {
            let terms: Vec<(f64, f64)> = self.scales[group]
                .iter()
                .map(|(scale, ln_p)| {
                    let precision = self.power / (scale * scale);
                    let ln_errors =
                        -0.5 * squares[group] * precision - self.power * counts[group] * scale.ln();
                    (ln_p + ln_errors, precision)
                })
                .collect();
            let greatest = terms
                .iter()
                .map(|(ln, _)| *ln)
                .fold(f64::NEG_INFINITY, f64::max);
            let sum: f64 = terms.iter().map(|(ln, _)| (ln - greatest).exp()).sum();
            ln_density += greatest + sum.ln();
            let mean = terms
                .iter()
                .map(|(ln, precision)| (ln - greatest).exp() * precision);
            mean.sum::<f64>() / sum
        });
        (ln_density, precisions)
    }

    /// The same where the variances of the errors are so many times the usual ones.
    pub(crate) fn ln_density_of_rough(
        &self,
        squares: [f64; GROUPS],
        rows: usize,
        times: [f64; GROUPS],
    ) -> (f64, [f64; GROUPS]) {
        let counts = self.groups(rows).map(|rows| rows.len() as f64);
        let less = |values: [f64; GROUPS]| std::array::from_fn(|k| values[k] / times[k]);
        let (ln_density, precisions) = self.ln_density(less(squares), rows);
        let ln_determinant: f64 = counts.iter().zip(times).map(|(n, by)| n * by.ln()).sum();
        (
            ln_density - 0.5 * self.power * ln_determinant,
            less(precisions),
        )
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::walk::record::tests::walking_record;

    /// Of robots that stand firmly.
    pub(crate) const SPREAD: Spread = Spread {
        tilt_deg: 0.3,
        turning_dps: 0.5,
    };

    /// How many numbers an error of `walking_record` has.
    pub(crate) fn rows() -> usize {
        Observation::new(&walking_record(), &Discrepancy::default(), 1.0).len()
    }

    /// For errors of single walks of such robots, compared with `walking_record`.
    pub(crate) fn whitening(discrepancy: &Discrepancy) -> Whitening {
        let record = walking_record();
        let observation = Observation::new(&record, discrepancy, 1.0);
        observation.whitening(SPREAD, Compared::Walk).unwrap()
    }
}
