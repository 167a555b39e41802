//! The mean walk of a hypothesis as a linear function of its coordinates, and its evidence.

use nalgebra::{DMatrix, DVector};

use crate::{
    laplace,
    walk::{
        evidence::curvature,
        linear_model::LinearModel,
        observation::{GROUPS, Whitening},
    },
};

/// The mean walk of one hypothesis as a function of its coordinates, as regression has found it.
#[derive(Debug, Clone)]
pub(super) struct LinearWalk {
    /// What it leaves of the log where all coordinates are 0.
    pub(super) at_zero: DVector<f64>,
    /// Change of the prediction per unit of each coordinate.
    pub(super) jacobian: DMatrix<f64>,
    /// Covariance of what regression found of each coordinate and, last, of the mean, for errors of
    /// unit variance.
    pub(super) uncertainty: DMatrix<f64>,
}

/// A mean walk with its coordinates integrated out.
#[derive(Debug)]
pub(super) struct Integrated {
    /// The most probable coordinates.
    pub(super) z: DVector<f64>,
    /// What they leave of the log.
    pub(super) residual: DVector<f64>,
    pub(super) jacobian: DMatrix<f64>,
    /// Of minus the logarithm of the likelihood.
    pub(super) curvature: DMatrix<f64>,
    pub(super) ln_evidence: f64,
}

impl LinearWalk {
    /// What the mean walk with these coordinates leaves of the log.
    pub(super) fn residual(&self, z: &DVector<f64>) -> DVector<f64> {
        &self.at_zero - &self.jacobian * z
    }

    /// Variance of what it leaves, for errors of unit variance.
    pub(super) fn variance_at(&self, z: &DVector<f64>) -> f64 {
        let at = z.clone().push(1.0);
        at.dot(&(&self.uncertainty * &at))
    }

    /// Covariance of its sensitivities for errors of unit variance.
    pub(super) fn covariance_of_slopes(&self) -> DMatrix<f64> {
        let p = self.jacobian.ncols();
        self.uncertainty.view((0, 0), (p, p)).clone_owned()
    }

    /// By Laplace's approximation where it is most probable within bounds, from `centre` on. `counting`
    /// makes coordinates of the walk of those of the hypothesis.
    ///
    /// The square of what regression has found is too great by its variance, which is taken off: the evidence
    /// is that of the mean of infinitely many walks, but for chance. `roughness` is the mean square of what
    /// single walks add to the errors, in variances of the discrepancy of usual scale.
    pub(super) fn integrated(
        &self,
        centre: &DVector<f64>,
        counting: &DMatrix<f64>,
        within_bounds: impl Fn(&mut DVector<f64>),
        whitening: &Whitening,
        roughness: [f64; GROUPS],
    ) -> Integrated {
        let jacobian = &self.jacobian * counting;
        let left = self.residual(&(counting * centre));
        let model = LinearModel::new(whitening, &left, centre, &jacobian);
        let (_, mut z) = model.ln_evidence(whitening);
        within_bounds(&mut z);
        let counted = counting * &z;
        let residual = self.residual(&counted);
        let rows = residual.len();
        let groups = whitening.groups(rows);
        // Sum of squares of the errors of a single walk.
        let rough: [f64; GROUPS] = std::array::from_fn(|k| groups[k].len() as f64 * roughness[k]);
        let variance = self.variance_at(&counted);
        let squares = whitening.squares(&residual);
        let squares = std::array::from_fn(|k| (squares[k] - rough[k] * variance).max(0.0));
        let (ln_density, precisions) = whitening.ln_density(squares, rows);
        let found = curvature(whitening, &model.jacobian, precisions);
        let rough: f64 = rough.iter().zip(precisions).map(|(r, p)| r * p).sum();
        let uncertain = counting.tr_mul(&(self.covariance_of_slopes() * counting));
        let curvature = without_negative_eigenvalues(found - rough * uncertain);
        Integrated {
            ln_evidence: ln_density - 0.5 * z.norm_squared()
                + laplace::ln_volume(curvature.clone()),
            z,
            residual,
            jacobian,
            curvature,
        }
    }
}

/// The nearest symmetric matrix that is a curvature.
fn without_negative_eigenvalues(matrix: DMatrix<f64>) -> DMatrix<f64> {
    let mut parts = matrix.symmetric_eigen();
    parts.eigenvalues.apply(|value| *value = value.max(0.0));
    parts.recompose()
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::walk::{
        Discrepancy, Observation,
        discrepancy::{Compared, Scatter},
        mean_walk::{
            regression::{Regression, Walks},
            tests::{Rough, whitening},
        },
        observation::tests::SPREAD,
        record::tests::walking_record,
    };

    const COORDINATES: usize = 20;

    fn ln_evidence(of: &LinearWalk, whitening: &Whitening, roughness: [f64; GROUPS]) -> f64 {
        let zero = DVector::zeros(COORDINATES);
        let counting = DMatrix::identity(COORDINATES, COORDINATES);
        of.integrated(&zero, &counting, |_| {}, whitening, roughness)
            .ln_evidence
    }

    /// The mean over seeds of what the evidence by so many walks is above that of the exact mean walk, with what
    /// regression does not know taken off, and without.
    fn mean_errors(draws: usize) -> [f64; 2] {
        const SEEDS: u64 = 12;
        let whitening = whitening();
        let mut sums = [0.0; 2];
        for seed in 0..SEEDS {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let rough = Rough::new(0.25, COORDINATES, &mut random);
            let known = rough.differences(&mut random);
            let walks: [Walks; 1] = [rough.walks(draws, 0.0, &mut random)];
            let regression = Regression::new(&walks, &known, &whitening).unwrap();
            let found = regression.of(0);
            let exact = LinearWalk {
                at_zero: rough.at_zero.clone(),
                jacobian: rough.jacobian.clone(),
                uncertainty: DMatrix::zeros(COORDINATES + 1, COORDINATES + 1),
            };
            let none = [0.0; GROUPS];
            let roughness = regression.roughness(&whitening);
            let exact = ln_evidence(&exact, &whitening, none);
            sums[0] += (ln_evidence(found, &whitening, roughness) - exact) / SEEDS as f64;
            sums[1] += (ln_evidence(found, &whitening, none) - exact) / SEEDS as f64;
        }
        sums
    }

    #[test]
    fn the_evidence_does_not_depend_on_how_many_walks_are_drawn() {
        let ([few, few_as_found], [many, many_as_found]) = (mean_errors(48), mean_errors(300));
        assert!(few.abs() < 1.0 && many.abs() < 0.5, "{few} {many}");
        // As found, the errors of single walks count as sensitivities, the more the fewer there are.
        assert!(few_as_found < -2.0, "{few_as_found}");
        assert!(many_as_found > few_as_found + 1.0, "{many_as_found}");
    }

    /// Mean and variance, over what walks are drawn, of the evidence of a robot whose single walks scatter so
    /// far, in units of what the mean usually leaves.
    fn evidence_by_draws(roughness: f64, compared: impl Fn(&Scatter) -> Compared<'_>) -> [f64; 2] {
        const SEEDS: u64 = 12;
        let record = walking_record();
        let observation = Observation::new(&record, &Discrepancy::of_means(), 1.0);
        let mut made = ChaCha8Rng::seed_from_u64(7);
        let rough = Rough::new(roughness, COORDINATES, &mut made);
        let known = rough.differences(&mut made);
        let usual = whitening();
        let evidences = (0..SEEDS).map(|seed| {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let walks: [Walks; 1] = [rough.walks(96, 0.0, &mut random)];
            let regression = Regression::new(&walks, &known, &usual).unwrap();
            let scatter = regression.scatter();
            let whitening = observation.whitening(SPREAD, compared(&scatter)).unwrap();
            let roughness = regression.roughness(&whitening);
            ln_evidence(regression.of(0), &whitening, roughness)
        });
        let evidences = DVector::from_vec(evidences.collect());
        [evidences.mean(), evidences.variance()]
    }

    #[test]
    fn where_walks_scatter_widely_evidence_is_low_and_certain() {
        let by_scatter = |roughness| evidence_by_draws(roughness, |s| Compared::MeanOf(s));
        let (firm, tipping) = (by_scatter(0.1), by_scatter(30.0));
        assert!(tipping[0] < firm[0] - 10.0, "{tipping:?} {firm:?}");
        // The control: as if they did not, it is up to the walks that were drawn.
        let as_if_firm = evidence_by_draws(30.0, |_| Compared::Walk);
        assert!(
            as_if_firm[1] > 30.0 * tipping[1],
            "{tipping:?} {as_if_firm:?}"
        );
    }

    #[test]
    fn coordinates_that_do_not_count_keep_their_prior() {
        let whitening = whitening();
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let rough = Rough::new(0.25, 3, &mut random);
        let walk = LinearWalk {
            at_zero: rough.at_zero.clone(),
            jacobian: rough.jacobian.clone(),
            uncertainty: DMatrix::zeros(4, 4),
        };
        let none = [0.0; GROUPS];
        let mut counting = DMatrix::identity(3, 3);
        counting[(1, 1)] = 0.0;
        let zero = DVector::zeros(3);
        let found = walk.integrated(&zero, &counting, |_| {}, &whitening, none);
        assert!(found.z[1].abs() < 1e-12 && found.curvature[(1, 1)].abs() < 1e-9);
        assert!(found.z[0].abs() > 1e-3 && found.curvature[(0, 0)] > 0.1);
        // Bounds hold, and what they forbid costs evidence.
        let bounded = walk.integrated(&zero, &counting, |z| z.fill(0.0), &whitening, none);
        assert!(bounded.z.norm() < 1e-12 && bounded.ln_evidence < found.ln_evidence);
    }
}
