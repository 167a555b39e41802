//! The equations of a regression over walks: weighted least squares, and what is known before.

use std::ops::Range;

use mlr_model::Impacts;
use nalgebra::DMatrix;

use super::regression::Walks;
use crate::walk::observation::Whitening;

/// Sensitivities known before are differences of two walks, each with errors of its own: over one unit
/// of a coordinate of the robot, over a part of one of an effect's.
const VARIANCE_OF_OWN: f64 = 2.0;
const VARIANCE_OF_EFFECTS: f64 = 50.0;
/// The mean may be anything.
const VARIANCE_OF_MEAN: f64 = 1e9;
/// Times that weights of walks and what is left of these are found from each other.
const REWEIGHTINGS: usize = 3;

/// What is regressed: a row of the design and a column of what sensitivities known before miss for each walk.
pub(super) struct Equations {
    pub(super) layout: Layout,
    pub(super) design: DMatrix<f64>,
    missed: DMatrix<f64>,
    /// Rows of each hypothesis.
    rows: Vec<Range<usize>>,
}

/// What walks with some weights say of the unknowns.
pub(super) struct Solution {
    /// Of the walks of each hypothesis.
    weights: Vec<f64>,
    /// Of each unknown, a column.
    pub(super) found: DMatrix<f64>,
    /// Covariance of the unknowns for errors of unit variance.
    pub(super) covariance: DMatrix<f64>,
    /// What is left of each walk, times the root of its weight.
    pub(super) left: DMatrix<f64>,
    /// The part of each walk's error that regression takes up.
    pub(super) leverages: Vec<f64>,
}

impl Equations {
    /// Of the walks of hypotheses on one robot, the sensitivities of whose own coordinates are `known`.
    pub(super) fn new(of: &[Walks], known: &DMatrix<f64>) -> Self {
        let layout = Layout::new(of, known.ncols());
        let count: usize = of.iter().map(|walks| walks.draws.len()).sum();
        let mut design = DMatrix::zeros(count, layout.columns);
        let mut missed = DMatrix::zeros(known.nrows(), count);
        let mut rows = Vec::with_capacity(of.len());
        let mut row = 0;
        for (k, walks) in of.iter().enumerate() {
            let columns = layout.of(k);
            rows.push(row..row + walks.draws.len());
            for draw in &walks.draws {
                for (column, z) in columns.iter().zip(draw.z.iter().chain([&1.0])) {
                    design[(row, *column)] = *z;
                }
                design[(row, layout.impacts())] = match draw.impacts {
                    Impacts::Rigid => -1.0,
                    Impacts::Compliant => 1.0,
                };
                let own = known * draw.z.rows(0, layout.own);
                let of_effects = &walks.known * draw.z.rows_range(layout.own..);
                missed.set_column(row, &(&draw.residual + own + of_effects));
                row += 1;
            }
        }
        Self {
            layout,
            design,
            missed,
            rows,
        }
    }

    /// Where walks weigh by how rough those of their hypothesis are; `whitening` is for their errors.
    pub(super) fn solved(&self, whitening: &Whitening) -> Option<Solution> {
        // The equations have the same weights for errors and for whitened ones.
        let whitened = whitening.apply(&self.missed);
        let mut weights = vec![1.0; self.rows.len()];
        for _ in 0..REWEIGHTINGS {
            weights = self.weights(&self.solution(&whitened, &weights)?);
        }
        self.solved_with(&weights)
    }

    /// Where the walks of each hypothesis have these weights.
    pub(super) fn solved_with(&self, weights: &[f64]) -> Option<Solution> {
        self.solution(&self.missed, weights)
    }

    /// Of walks of which sensitivities known before miss this, with these weights.
    fn solution(&self, missed: &DMatrix<f64>, weights: &[f64]) -> Option<Solution> {
        let (mut design, mut left) = (self.design.clone(), missed.clone());
        for (rows, weight) in self.rows.iter().zip(weights) {
            let (first, count) = (rows.start, rows.len());
            design.rows_mut(first, count).scale_mut(weight.sqrt());
            left.columns_mut(first, count).scale_mut(weight.sqrt());
        }
        let mut normal = design.tr_mul(&design);
        for k in 0..self.layout.columns {
            normal[(k, k)] += self.layout.variance(k).recip();
        }
        let covariance = normal.cholesky()?.inverse();
        let found = &left * &design * &covariance;
        left -= &found * design.transpose();
        let leverages = (&design * &covariance).component_mul(&design);
        Some(Solution {
            weights: weights.to_vec(),
            leverages: leverages.row_iter().map(|row| row.sum()).collect(),
            found,
            covariance,
            left,
        })
    }

    /// The weights of walks by how rough those of each hypothesis are in this solution for whitened errors; 1 in
    /// the mean.
    fn weights(&self, solved: &Solution) -> Vec<f64> {
        let precisions = self.rows.iter().enumerate().map(|(k, rows)| {
            let taken_up: f64 = solved.leverages[rows.clone()].iter().sum();
            let freedom = (rows.len() as f64 - taken_up).max(1.0);
            let left = solved.left.columns(rows.start, rows.len());
            let square = left.norm_squared() / solved.weights[k];
            freedom / square.max(f64::MIN_POSITIVE)
        });
        let precisions: Vec<f64> = precisions.collect();
        let counts = self.rows.iter().map(|rows| rows.len() as f64);
        let sum: f64 = counts.zip(&precisions).map(|(n, p)| n * p).sum();
        let mean = sum / self.design.nrows() as f64;
        precisions
            .iter()
            .map(|precision| precision / mean)
            .collect()
    }
}

/// The unknowns of a regression: what sensitivities to the robot's own coordinates miss, then for each
/// hypothesis the same of its effects, and its mean, and in the end what impacts change.
pub(super) struct Layout {
    /// Coordinates of the robot itself.
    pub(super) own: usize,
    of_effects: Vec<Range<usize>>,
    columns: usize,
}

impl Layout {
    fn new(of: &[Walks], own: usize) -> Self {
        let mut columns = own;
        let of_effects = of.iter().map(|walks| {
            let first = columns;
            columns += walks.known.ncols() + 1;
            first..columns - 1
        });
        let of_effects = of_effects.collect();
        Self {
            own,
            of_effects,
            columns: columns + 1,
        }
    }

    /// The column of what impacts change.
    pub(super) fn impacts(&self) -> usize {
        self.columns - 1
    }

    /// The columns of a hypothesis: of its coordinates in their order, and of its mean.
    pub(super) fn of(&self, index: usize) -> Vec<usize> {
        let effects = self.of_effects[index].clone();
        let mean = effects.end;
        (0..self.own).chain(effects).chain([mean]).collect()
    }

    /// Before any walk.
    fn variance(&self, column: usize) -> f64 {
        let is_mean = self.of_effects.iter().any(|range| range.end == column);
        match is_mean || column == self.impacts() {
            true => VARIANCE_OF_MEAN,
            false if column < self.own => VARIANCE_OF_OWN,
            false => VARIANCE_OF_EFFECTS,
        }
    }
}
