//! How a walk answers to each parameter of a hypothesis.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::{Coordinate, Walked, Walker};

impl Walker<'_> {
    /// Change of the prediction per unit of each coordinate. What makes a walk diverge changes
    /// nothing.
    pub(crate) fn jacobian(&self, at: &Walked) -> DMatrix<f64> {
        self.mixed(self.changes(at, 0..self.dimension()))
    }

    /// The same of the parameters of effects alone.
    pub(crate) fn jacobian_of_effects(&self, at: &Walked) -> DMatrix<f64> {
        self.jacobian_of_added(at, self.nuisances())
    }

    /// The same without so many first coordinates, all of the nuisance parameters among them.
    pub(crate) fn jacobian_of_added(&self, at: &Walked, first: usize) -> DMatrix<f64> {
        self.changes(at, first.max(self.nuisances())..self.dimension())
    }

    /// Change of the prediction per unit of some parameters: of deviations of nuisance parameters and
    /// of coordinates of the effects'.
    fn changes(&self, at: &Walked, columns: std::ops::Range<usize>) -> DMatrix<f64> {
        let record = self.observation.record;
        let samples = self.observation.samples();
        let deviations = self.deviations(&at.z);
        let columns: Vec<usize> = columns.collect();
        let changes: Vec<DVector<f64>> = columns
            .par_iter()
            .map(|&k| {
                if matches!(self.coordinates[k], Coordinate::Replaced(_)) {
                    return DVector::zeros(self.observation.len());
                }
                let (mut moved, mut robot) = (at.z.clone(), deviations.clone());
                let step = self.step(k, &at.z);
                match robot.get_mut(k) {
                    Some(deviation) => *deviation += step,
                    None => moved[k] += step,
                }
                let model = self.with_effects(self.robot_with(&robot), &moved);
                let prediction = if self.is_of_sensing(k) {
                    Some(model.predict(&at.body, record, samples))
                } else {
                    let walked = model.walk(&self.hypothesis.morphology, record, samples);
                    walked
                        .ok()
                        .flatten()
                        .map(|body| model.predict(&body, record, samples))
                };
                prediction.map_or_else(
                    || DVector::zeros(self.observation.len()),
                    |to| self.observation.change(&at.prediction, &to) / step,
                )
            })
            .collect();
        if changes.is_empty() {
            return DMatrix::zeros(self.observation.len(), 0);
        }
        DMatrix::from_columns(&changes)
    }

    /// A step of a parameter that stays within its bounds: a standard deviation of a nuisance
    /// parameter, as far as it is known.
    fn step(&self, k: usize, z: &DVector<f64>) -> f64 {
        match &self.coordinates[k] {
            Coordinate::Nuisance(_) | Coordinate::Replaced(_) => {
                let mixing = self.mixing.as_ref();
                mixing.map_or(1.0, |mixing| mixing.row(k).norm())
            }
            Coordinate::Effect { parameter, .. } => {
                let step = 0.2;
                let ahead = z[k] + step;
                if parameter.within_bounds(ahead) < ahead {
                    -step
                } else {
                    step
                }
            }
        }
    }

    /// Sensitivities to coordinates from those to deviations of the nuisance parameters, which come
    /// first.
    pub(super) fn mixed(&self, mut of_deviations: DMatrix<f64>) -> DMatrix<f64> {
        if let Some(mixing) = &self.mixing {
            let n = mixing.nrows();
            let mixed = of_deviations.columns(0, n) * mixing;
            of_deviations.columns_mut(0, n).copy_from(&mixed);
        }
        of_deviations
    }

    /// The reverse of [`Self::mixed`].
    pub(super) fn unmixed(&self, mut of_coordinates: DMatrix<f64>) -> DMatrix<f64> {
        if let Some(mixing) = &self.mixing {
            let n = mixing.nrows();
            // A L = B is Lᵀ Aᵀ = Bᵀ.
            let mixed = of_coordinates.columns(0, n).transpose();
            if let Some(unmixed) = mixing.tr_solve_lower_triangular(&mixed) {
                of_coordinates
                    .columns_mut(0, n)
                    .copy_from(&unmixed.transpose());
            }
        }
        of_coordinates
    }

    /// Takes what nuisance parameters change that an effect replaces out of sensitivities to
    /// coordinates.
    pub(crate) fn without_replaced(&self, jacobian: DMatrix<f64>) -> DMatrix<f64> {
        let is_replaced = |k: &usize| matches!(self.coordinates[*k], Coordinate::Replaced(_));
        let replaced: Vec<usize> = (0..self.nuisances()).filter(is_replaced).collect();
        if replaced.is_empty() {
            return jacobian;
        }
        let mut unmixed = self.unmixed(jacobian);
        for k in replaced {
            unmixed.column_mut(k).fill(0.0);
        }
        self.mixed(unmixed)
    }

    /// Sensitivities like those of another robot, as far as both have the same parameters: the others change nothing.
    pub(crate) fn with_slopes_of(&self, other: &Self, jacobian: &DMatrix<f64>) -> DMatrix<f64> {
        let of_other = other.unmixed(jacobian.clone());
        let mut slopes = DMatrix::zeros(jacobian.nrows(), self.dimension());
        for (k, known) in self.same_in(other) {
            slopes.column_mut(k).copy_from(&of_other.column(known));
        }
        self.mixed(slopes)
    }
}
