//! ln p(log | hypothesis): the probability density of a record, every parameter of the hypothesis
//! integrated out by Laplace's approximation.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::{
    hypothesis::{Walked, Walker},
    linear_model::{LinearModel, NormalEquations, Step},
    observation::{GROUPS, Whitening},
};
use crate::{
    laplace::{self, ln_volume},
    ln_mean,
};

/// A hypothesis at its most probable parameters.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    pub(crate) walked: Walked,
    /// Change of the prediction per unit of each coordinate.
    pub(crate) jacobian: DMatrix<f64>,
    /// Curvature of minus the logarithm of the likelihood.
    pub(crate) curvature: DMatrix<f64>,
    /// Logarithm of the evidence.
    pub(crate) ln_evidence: f64,
    /// Measured less predicted: by this walk, or by the mean of walks about it.
    pub(crate) residual: DVector<f64>,
}

/// Steps that are tried beside each other: to where the linear model is most probable if its errors
/// will be as usual, and if they are what it leaves, held back more and more (Levenberg), in units
/// of the prior's precision.
const STEPS: [Step; 4] = [
    Step::Bold,
    Step::Damped(0.0),
    Step::Damped(10.0),
    Step::Damped(150.0),
];
/// A fit whose last step raised the logarithm of the posterior density by less has converged: far
/// below what changes a probability.
const CONVERGED: f64 = 0.15;

/// Logarithm of the evidence of a linear model about its most probable coordinates, whose prior is
/// standard normal, with the curvature of minus the logarithm of the likelihood: `residual` is what
/// these coordinates leave.
///
/// Laplace's approximation: the integral of likelihood times prior is their product at its
/// maximum times the square root of the determinant of the posterior's covariance. It is exact
/// where the prediction is linear.
pub(crate) fn ln_evidence(
    whitening: &Whitening,
    residual: &DVector<f64>,
    coordinates: &DVector<f64>,
    jacobian: &DMatrix<f64>,
) -> (f64, DMatrix<f64>) {
    let (ln_density, precisions) =
        whitening.ln_density(whitening.squares(residual), residual.len());
    let curvature = curvature(whitening, &whitening.apply(jacobian), precisions);
    let ln_posterior = ln_density - 0.5 * coordinates.norm_squared();
    (ln_posterior + ln_volume(curvature.clone()), curvature)
}

/// Curvature of minus the logarithm of the likelihood.
pub(super) fn curvature(
    whitening: &Whitening,
    whitened_jacobian: &DMatrix<f64>,
    precisions: [f64; GROUPS],
) -> DMatrix<f64> {
    let p = whitened_jacobian.ncols();
    let groups = whitening.groups(whitened_jacobian.nrows());
    let mut sum = DMatrix::zeros(p, p);
    for (rows, precision) in groups.into_iter().zip(precisions) {
        let rows = whitened_jacobian.rows_range(rows);
        sum += precision * rows.tr_mul(&rows);
    }
    sum
}

/// Logarithm of likelihood times prior density at these coordinates.
fn ln_posterior(whitening: &Whitening, walked: &Walked) -> f64 {
    let squares = whitening.squares(&walked.residual);
    let (ln_density, _) = whitening.ln_density(squares, walked.residual.len());
    ln_density - 0.5 * walked.z.norm_squared()
}

impl Walker<'_> {
    /// The most probable coordinates by a linear model, those of the body's nuisance parameters kept.
    pub(crate) fn at_kept_body(&self, model: &LinearModel, whitening: &Whitening) -> DVector<f64> {
        let moves = |k: &usize| *k >= self.nuisances() || self.is_of_sensing(*k);
        let moving: Vec<usize> = (0..self.dimension()).filter(moves).collect();
        let own = LinearModel {
            residual: model.residual.clone(),
            coordinates: model.coordinates.select_rows(&moving),
            jacobian: model.jacobian.select_columns(&moving),
            held: 0,
        };
        let (_, found) = own.ln_evidence(whitening);
        let mut coordinates = model.coordinates.clone();
        for (k, z) in moving.into_iter().zip(found.iter()) {
            coordinates[k] = *z;
        }
        coordinates
    }

    /// Up to so many steps from these parameters, by sensitivities found there; `None` where it does not walk.
    pub(crate) fn fitted(
        &self,
        z: DVector<f64>,
        whitening: &Whitening,
        steps: usize,
    ) -> Option<Fit> {
        let walked = self.walk(z)?;
        let jacobian = self.jacobian(&walked);
        Some(self.advanced(walked, jacobian, whitening, steps))
    }

    /// Up to so many steps of Gauss and Newton's method towards the most probable parameters.
    pub(crate) fn advanced(
        &self,
        start: Walked,
        mut jacobian: DMatrix<f64>,
        whitening: &Whitening,
        steps: usize,
    ) -> Fit {
        let mut here = start;
        let mut ln_here = ln_posterior(whitening, &here);
        for _ in 0..steps {
            let model = LinearModel::new(whitening, &here.residual, &here.z, &jacobian);
            let equations = NormalEquations::new(&model, whitening);
            let tried = STEPS.into_par_iter().filter_map(|step| {
                let mut z = &here.z + equations.step(whitening, step).0;
                self.clamp(&mut z);
                let tried = self.walk(z)?;
                let ln_tried = ln_posterior(whitening, &tried);
                Some((tried, ln_tried))
            });
            let Some((tried, ln_tried)) = tried.max_by(|a, b| a.1.total_cmp(&b.1)) else {
                break;
            };
            let gain = ln_tried - ln_here;
            let moved = &tried.z - &here.z;
            let missed = (&here.residual - &tried.residual) - &jacobian * &moved;
            if gain > 0.0 {
                (here, ln_here) = (tried, ln_tried);
            }
            if (0.0..CONVERGED).contains(&gain) {
                break;
            }
            // Broyden's update: the walks just made tell more about the slopes.
            jacobian += missed * moved.transpose() / moved.norm_squared().max(1e-9);
        }
        self.integrated(here, jacobian, whitening)
    }

    /// The likeliest of these points; `None` when no walk from any of them stays finite.
    pub(crate) fn likelier(
        &self,
        mut points: Vec<DVector<f64>>,
        whitening: &Whitening,
    ) -> Option<Walked> {
        // Several ways to a start often lead to the same: it is walked once.
        points.dedup();
        let walked = points.into_par_iter().filter_map(|z| {
            let walked = self.walk(z)?;
            Some((ln_posterior(whitening, &walked), walked))
        });
        let best = walked.max_by(|(a, _), (b, _)| a.total_cmp(b));
        best.map(|(_, walked)| walked)
    }

    /// Laplace's approximation at parameters whose first coordinates keep the slopes that are known; the others
    /// take their own.
    pub(crate) fn begun(&self, at: Walked, known: &DMatrix<f64>, whitening: &Whitening) -> Fit {
        let first = known.ncols();
        let own = self.jacobian_of_added(&at, first);
        let mut jacobian = known.clone().insert_columns(first, own.ncols(), 0.0);
        jacobian.columns_mut(first, own.ncols()).copy_from(&own);
        self.integrated(at, self.without_replaced(jacobian), whitening)
    }

    /// Laplace's approximation at these parameters.
    pub(crate) fn integrated(
        &self,
        at: Walked,
        jacobian: DMatrix<f64>,
        whitening: &Whitening,
    ) -> Fit {
        let (ln_evidence, curvature) = ln_evidence(whitening, &at.residual, &at.z, &jacobian);
        Fit {
            ln_evidence,
            curvature,
            residual: at.residual.clone(),
            walked: at,
            jacobian,
        }
    }
}

impl Fit {
    /// Covariance of the coordinates.
    pub(crate) fn covariance(&self) -> DMatrix<f64> {
        laplace::covariance(self.curvature.clone())
    }

    /// Logarithm of the factor by which errors that are not the usual ones raise the evidence: its mean over the ways in
    /// which something unknown may act.
    pub(crate) fn ln_gain_of_unknown(&self, usual: &Whitening, with_unknown: &[Whitening]) -> f64 {
        let ln = |whitening: &Whitening| {
            let coordinates = &self.walked.z;
            let model = LinearModel::new(whitening, &self.residual, coordinates, &self.jacobian);
            model.ln_evidence(whitening).0
        };
        ln_mean(with_unknown.iter().map(ln), with_unknown.len()) - ln(usual)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Cholesky, DMatrix, DVector};
    use rand::{RngExt as _, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::walk::{
        Discrepancy, Observation, WalkRecord,
        observation::tests::{SPREAD, rows, whitening},
        record::tests::walking_record,
    };

    /// A discrepancy whose scale is known and whose likelihood counts in full.
    fn of_known_scale() -> Discrepancy {
        let mut discrepancy = Discrepancy::default();
        for axis in [&mut discrepancy.tilt, &mut discrepancy.yaw] {
            (axis.ln_scale_deviation, axis.ln_scale_spread) = (1e-3, 0.0);
        }
        Discrepancy {
            power: 1.0,
            ..discrepancy
        }
    }

    /// Errors as the discrepancy makes them, and sensitivities of so many parameters at random.
    fn random_model(record: &WalkRecord, parameters: usize) -> (DVector<f64>, DMatrix<f64>) {
        let observation = Observation::new(record, &of_known_scale(), 1.0);
        let n = observation.len();
        let mut random = ChaCha8Rng::seed_from_u64(1);
        // The sum of twelve uniform numbers is normal for this purpose.
        let mut normal = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
        let independent = DVector::from_fn(n, |_, _| normal());
        let factor = Cholesky::new(observation.covariance(SPREAD)).unwrap().l();
        let jacobian = DMatrix::from_fn(n, parameters, |_, _| 0.1 * normal());
        (factor * independent, jacobian)
    }

    /// Logarithm of the density of a residual whose model is linear: normal, with the covariance of
    /// the errors and of what the parameters make. Up to the constant that evidences leave out.
    fn marginal(
        covariance: &DMatrix<f64>,
        residual: &DVector<f64>,
        jacobian: &DMatrix<f64>,
    ) -> f64 {
        let total = covariance + jacobian * jacobian.transpose();
        let factors = Cholesky::new(total).unwrap();
        let ln_determinant = 2.0 * factors.l().diagonal().map(f64::ln).sum();
        -0.5 * residual.dot(&factors.solve(residual)) - 0.5 * ln_determinant
    }

    #[test]
    fn the_evidence_of_a_linear_model_is_its_marginal_density() {
        let record = walking_record();
        let observation = Observation::new(&record, &of_known_scale(), 1.0);
        let whitening = whitening(&of_known_scale());
        let covariance = observation.covariance(SPREAD);
        let exact = |parameters: usize| {
            let (residual, jacobian) = random_model(&record, parameters);
            let linear = LinearModel {
                residual: whitening
                    .apply(&DMatrix::from_columns(std::slice::from_ref(&residual)))
                    .column(0)
                    .into(),
                coordinates: DVector::zeros(parameters),
                jacobian: whitening.apply(&jacobian),
                held: 0,
            };
            let (ln_linear, best) = linear.ln_evidence(&whitening);
            let left = &residual - &jacobian * &best;
            let (ln_laplace, _) = ln_evidence(&whitening, &left, &best, &jacobian);
            // The first three of yaw's zero: the constants of the rates at rest are in both.
            let expected = marginal(&covariance, &residual, &jacobian);
            assert!(
                (ln_linear - expected).abs() < 1e-6 * expected.abs(),
                "{ln_linear} {expected}"
            );
            assert!(
                (ln_laplace - expected).abs() < 1e-6 * expected.abs(),
                "{ln_laplace} {expected}"
            );
            // Anywhere else, less is left of the posterior.
            let elsewhere = &best + DVector::from_element(parameters, 0.1);
            let left = &residual - &jacobian * &elsewhere;
            assert!(ln_evidence(&whitening, &left, &elsewhere, &jacobian).0 < expected - 1e-3);
        };
        exact(1);
        exact(5);
    }

    #[test]
    fn a_parameter_that_explains_nothing_costs_its_freedom() {
        let whitening = whitening(&of_known_scale());
        let (_, jacobian) = random_model(&walking_record(), 2);
        let nothing = DVector::zeros(rows());
        let ln = |columns: usize| {
            let jacobian = jacobian.columns(0, columns).clone_owned();
            ln_evidence(&whitening, &nothing, &DVector::zeros(columns), &jacobian).0
        };
        assert!(ln(2) < ln(1) && ln(1) < ln(0));
        // One that explains what is there is worth it.
        let shown = jacobian.column(0) * 2.0;
        let without = ln_evidence(
            &whitening,
            &shown,
            &DVector::zeros(0),
            &jacobian.columns(0, 0).clone_owned(),
        )
        .0;
        let one = jacobian.columns(0, 1).clone_owned();
        let with = ln_evidence(&whitening, &nothing, &DVector::from_element(1, 2.0), &one).0;
        assert!(with > without + 10.0, "{with} {without}");
    }

    #[test]
    fn the_power_of_the_likelihood_scales_what_evidence_convicts_by() {
        let record = walking_record();
        let gain = |power: f64| {
            let discrepancy = Discrepancy {
                power,
                ..of_known_scale()
            };
            let whitening = whitening(&discrepancy);
            let (residual, jacobian) = random_model(&record, 0);
            let ln = |residual: &DVector<f64>| {
                ln_evidence(&whitening, residual, &DVector::zeros(0), &jacobian).0
            };
            ln(&(&residual * 0.95)) - ln(&residual)
        };
        assert!((gain(0.2) / gain(1.0) - 0.2).abs() < 1e-6);
    }
}
