//! Linear models of hypotheses: what steps promise, without a walk.

use nalgebra::{DMatrix, DVector};

use super::observation::{GROUPS, Whitening};
use crate::laplace::ln_volume;

/// Whitened residual and sensitivities about some coordinates: a linear model of a hypothesis.
#[derive(Debug, Clone)]
pub(crate) struct LinearModel {
    pub(crate) residual: DVector<f64>,
    pub(crate) coordinates: DVector<f64>,
    pub(crate) jacobian: DMatrix<f64>,
    /// The last so many coordinates stay near where they are: the model is linear there only.
    pub(crate) held: usize,
}

/// How far to step.
#[derive(Debug, Clone, Copy)]
pub(super) enum Step {
    /// As if the errors that are left had the usual scale.
    Bold,
    /// With the scale that the errors left have, and a damping.
    Damped(f64),
}

/// How far coordinates stay that a linear model is held at, in standard deviations of their priors.
const REACH: f64 = 0.5;

/// Times that the scale of the discrepancy and the coordinates are found from each other.
const REWEIGHTINGS: usize = 12;

/// A linear model by what of it does not change with the step: sums over the whitened samples of
/// each group.
pub(super) struct NormalEquations<'m> {
    model: &'m LinearModel,
    groups: [Sums; GROUPS],
}

struct Sums {
    curvature: DMatrix<f64>,
    slope: DVector<f64>,
    square: f64,
}

impl Sums {
    /// Of what a step leaves.
    fn square_after(&self, step: &DVector<f64>) -> f64 {
        let left = self.square - 2.0 * self.slope.dot(step) + step.dot(&(&self.curvature * step));
        left.max(0.0)
    }
}

impl<'m> NormalEquations<'m> {
    pub(super) fn new(model: &'m LinearModel, whitening: &Whitening) -> Self {
        let groups = whitening.groups(model.residual.len()).map(|rows| {
            let jacobian = model.jacobian.rows_range(rows.clone());
            let residual = model.residual.rows_range(rows);
            Sums {
                curvature: jacobian.tr_mul(&jacobian),
                slope: jacobian.tr_mul(&residual),
                square: residual.norm_squared(),
            }
        });
        Self { model, groups }
    }

    fn with_precisions(&self, precisions: [f64; GROUPS]) -> (DMatrix<f64>, DVector<f64>) {
        let p = self.model.jacobian.ncols();
        let mut curvature = DMatrix::zeros(p, p);
        let mut slope = DVector::zeros(p);
        for (sums, precision) in self.groups.iter().zip(precisions) {
            curvature += precision * &sums.curvature;
            slope += precision * &sums.slope;
        }
        (curvature, slope)
    }

    /// The step, and the whitened sums of squares that it leaves.
    pub(super) fn step(&self, whitening: &Whitening, step: Step) -> (DVector<f64>, [f64; GROUPS]) {
        let p = self.model.jacobian.ncols();
        let (damping, reweightings) = match step {
            Step::Bold => (0.0, 1),
            Step::Damped(damping) => (damping, REWEIGHTINGS),
        };
        let mut precisions = whitening.usual_precisions();
        let mut found = (
            DVector::zeros(p),
            std::array::from_fn(|k| self.groups[k].square),
        );
        for _ in 0..reweightings {
            let (mut normal, slope) = self.with_precisions(precisions);
            for k in 0..p {
                normal[(k, k)] += 1.0 + damping;
            }
            for k in p - self.model.held..p {
                normal[(k, k)] += REACH.powi(-2);
            }
            let Some(factors) = normal.cholesky() else {
                break;
            };
            let step = factors.solve(&(slope - &self.model.coordinates));
            let squares = std::array::from_fn(|k| self.groups[k].square_after(&step));
            found = (step, squares);
            precisions = whitening.ln_density(squares, self.model.residual.len()).1;
        }
        found
    }
}

impl LinearModel {
    /// About these coordinates, which leave `residual`; none is held.
    pub(crate) fn new(
        whitening: &Whitening,
        residual: &DVector<f64>,
        coordinates: &DVector<f64>,
        jacobian: &DMatrix<f64>,
    ) -> Self {
        Self {
            residual: whitening.apply_to(residual),
            coordinates: coordinates.clone(),
            jacobian: whitening.apply(jacobian),
            held: 0,
        }
    }

    /// The whitened residual after a step.
    pub(crate) fn residual_after(&self, step: &DVector<f64>) -> DVector<f64> {
        &self.residual - &self.jacobian * step
    }

    /// Logarithm of the evidence, and the most probable coordinates.
    pub(crate) fn ln_evidence(&self, whitening: &Whitening) -> (f64, DVector<f64>) {
        self.ln_evidence_of_rough(whitening, |_| [1.0; GROUPS])
    }

    /// The same where the model itself errs: variances of the errors are so many times the usual ones, by
    /// the step to the most probable coordinates.
    pub(crate) fn ln_evidence_of_rough(
        &self,
        whitening: &Whitening,
        times: impl Fn(&DVector<f64>) -> [f64; GROUPS],
    ) -> (f64, DVector<f64>) {
        let equations = NormalEquations::new(self, whitening);
        let (step, squares) = equations.step(whitening, Step::Damped(0.0));
        let times = times(&step);
        let coordinates = &self.coordinates + step;
        let (ln_density, precisions) =
            whitening.ln_density_of_rough(squares, self.residual.len(), times);
        let (curvature, _) = equations.with_precisions(precisions);
        let ln_posterior = ln_density - 0.5 * coordinates.norm_squared();
        (ln_posterior + ln_volume(curvature), coordinates)
    }
}
