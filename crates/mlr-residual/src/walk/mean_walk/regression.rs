//! Walks as a linear function of their parameters, by ridge regression.

use mlr_model::Impacts;
use nalgebra::{DMatrix, DVector};

use super::{equations::Equations, linear_walk::LinearWalk};
use crate::walk::{
    discrepancy::Scatter,
    observation::{GROUPS, Whitening},
};

/// A walk with its coordinates.
#[derive(Debug, Clone)]
pub(super) struct Draw {
    /// Of the robot and the effects of its hypothesis.
    pub(super) z: DVector<f64>,
    pub(super) impacts: Impacts,
    /// What it leaves of the log.
    pub(super) residual: DVector<f64>,
}

/// The walks of one hypothesis.
#[derive(Debug)]
pub(super) struct Walks {
    pub(super) draws: Vec<Draw>,
    /// Sensitivities of its effects known before: change of the prediction per unit of each coordinate.
    pub(super) known: DMatrix<f64>,
}

/// What walks say of the hypotheses that they belong to: of each
///
/// ```text
/// r(z) = f − J z + e
/// ```
///
/// with a mean f of its own and sensitivities J, of which those to the robot's own coordinates are the same for
/// all. e is what single walks add: half of how walks with compliant impacts differ from those with rigid ones, or less
/// that, and what differs from walk to walk. Where this is more for one hypothesis than for another, the walks of each
/// weigh by its inverse variance (weighted least squares): else one whose walks jump, or are as sensitive as no other's,
/// would make the errors of all seem large, and what regression does not know of their means with them.
#[derive(Debug)]
pub(super) struct Regression {
    of: Vec<LinearWalk>,
    /// What compliant impacts add to the mean of both kinds.
    of_impacts: DVector<f64>,
    /// What else single walks add to the errors, a column for each, times the root of its weight.
    left: DMatrix<f64>,
    /// As many walks as are left of these, regression having taken up a part.
    freedom: f64,
}

impl Regression {
    /// Of the walks of hypotheses on one robot, the sensitivities of whose own coordinates are `known`, as
    /// surely as a difference of two walks tells them; `whitening` is for their errors. `None` where there is no walk.
    pub(super) fn new(of: &[Walks], known: &DMatrix<f64>, whitening: &Whitening) -> Option<Self> {
        let equations = Equations::new(of, known);
        let count = equations.design.nrows();
        if count == 0 {
            return None;
        }
        let solution = equations.solved(whitening)?;
        let layout = &equations.layout;
        let (found, covariance) = (&solution.found, &solution.covariance);
        let of = of.iter().enumerate().map(|(k, walks)| {
            let columns = layout.of(k);
            let p = columns.len() - 1;
            let mut jacobian = known.clone().resize_horizontally(p, 0.0);
            jacobian
                .columns_range_mut(layout.own..)
                .copy_from(&walks.known);
            LinearWalk {
                at_zero: found.column(columns[p]).clone_owned(),
                jacobian: jacobian - found.select_columns(&columns[..p]),
                uncertainty: covariance.select_rows(&columns).select_columns(&columns),
            }
        });
        let taken_up: f64 = solution.leverages.iter().sum();
        Some(Self {
            of: of.collect(),
            of_impacts: found.column(layout.impacts()).clone_owned(),
            left: solution.left,
            freedom: (count as f64 - taken_up).max(1.0),
        })
    }

    /// Mean square of what single walks add to the errors, in variances of the discrepancy of usual scale, group
    /// by group.
    pub(super) fn roughness(&self, whitening: &Whitening) -> [f64; GROUPS] {
        let whitened = whitening.apply(&self.left);
        whitening.groups(self.left.nrows()).map(|rows| {
            let count = rows.len().max(1) as f64 * self.freedom;
            whitened.rows_range(rows).norm_squared() / count
        })
    }

    /// How single walks scatter about the mean.
    pub(super) fn scatter(&self) -> Scatter {
        Scatter {
            walks: &self.left / self.freedom.sqrt(),
            impacts: self.of_impacts.clone(),
        }
    }

    /// That of the hypothesis with this index.
    pub(super) fn of(&self, index: usize) -> &LinearWalk {
        &self.of[index]
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::walk::mean_walk::tests::{Rough, whitening};

    #[test]
    fn linear_walks_are_found_and_how_rough_they_are() {
        let whitening = whitening();
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let rough = Rough::new(0.3, 4, &mut random);
        let walks = [0.0, 2.0].map(|shift| rough.walks(120, shift, &mut random));
        // What is known before is as wrong as a difference of two walks.
        let known = rough.differences(&mut random);
        let found = Regression::new(&walks, &known, &whitening).unwrap();
        for roughness in &found.roughness(&whitening)[..2] {
            assert!((roughness / 0.09 - 1.0).abs() < 0.1, "{roughness}");
        }
        let z = DVector::from_vec(vec![0.5, -0.2, 0.1, 0.4]);
        for (k, shift) in [0.0, 2.0].into_iter().enumerate() {
            let walk = found.of(k);
            let off = walk.residual(&z) - rough.mean(&z, shift);
            let rows = off.len() as f64;
            let variance = whitening.squares(&off).iter().sum::<f64>() / rows / 0.09;
            let expected = walk.variance_at(&z);
            assert!(
                (0.5..2.0).contains(&(variance / expected)),
                "{variance} {expected}"
            );
            let before = whitening.apply(&(&known - &rough.jacobian)).norm();
            let after = whitening.apply(&(&walk.jacobian - &rough.jacobian)).norm();
            assert!(after < 0.2 * before, "{after} {before}");
        }
    }

    #[test]
    fn walks_of_one_hypothesis_tell_what_another_has_in_common_with_it() {
        let whitening = whitening();
        let mut random = ChaCha8Rng::seed_from_u64(4);
        let rough = Rough::new(0.3, 4, &mut random);
        let known = rough.differences(&mut random);
        let mut slopes_of = |others: usize| {
            let walks: Vec<Walks> = (0..=others)
                .map(|_| rough.walks(24, 0.0, &mut random))
                .collect();
            let found = Regression::new(&walks, &known, &whitening).unwrap();
            found.of(0).covariance_of_slopes().trace()
        };
        let (alone, beside_three) = (slopes_of(0), slopes_of(3));
        assert!(beside_three < 0.4 * alone, "{beside_three} {alone}");
    }

    #[test]
    fn walks_that_are_rough_or_of_another_kind_spoil_no_others() {
        let whitening = whitening();
        let mut random = ChaCha8Rng::seed_from_u64(8);
        let firm = Rough::new(0.3, 4, &mut random);
        let other = Rough::new(9.0, 4, &mut random);
        let known = firm.differences(&mut random);
        let walks = [&firm, &other].map(|robot| robot.walks(36, 0.0, &mut random));
        let alone = Regression::new(&walks[..1], &known, &whitening).unwrap();
        let beside = Regression::new(&walks, &known, &whitening).unwrap();
        // What is known of the mean of the firm one, in variances of the discrepancy.
        let centre = DVector::zeros(4);
        let known_to =
            |found: &Regression| found.roughness(&whitening)[0] * found.of(0).variance_at(&centre);
        let share = known_to(&beside) / known_to(&alone);
        assert!((0.5..2.0).contains(&share), "{share}");
        let off = beside.of(0).residual(&centre) - alone.of(0).residual(&centre);
        let off = whitening.squares(&off)[0] / off.len() as f64;
        assert!(off < 2.0 * known_to(&alone), "{off}");

        // The control: where all walks weigh the same, little seems to be known of the firm one.
        let equations = Equations::new(&walks, &known);
        let alike = equations.solved_with(&[1.0, 1.0]).unwrap();
        let rough = whitening.apply(&alike.left).norm_squared() / (72.0 * known.nrows() as f64);
        let mean = equations.layout.of(0)[4];
        let as_if_alike = rough * alike.covariance[(mean, mean)];
        assert!(as_if_alike > 20.0 * known_to(&alone), "{as_if_alike}");
    }

    #[test]
    fn what_impacts_change_is_found_and_is_no_scatter() {
        let whitening = whitening();
        let mut random = ChaCha8Rng::seed_from_u64(6);
        let rough = Rough::new(0.3, 4, &mut random);
        let known = rough.differences(&mut random);
        let mut walks = [rough.walks(120, 0.0, &mut random)];
        let change = 3.0 * rough.jacobian.column(0);
        for draw in &mut walks[0].draws {
            match draw.impacts {
                Impacts::Rigid => draw.residual -= &change,
                Impacts::Compliant => draw.residual += &change,
            }
        }
        let found = Regression::new(&walks, &known, &whitening).unwrap();
        let off = whitening.apply_to(&(found.scatter().impacts - &change));
        let all = whitening.apply_to(&change);
        assert!(
            off.norm() < 0.1 * all.norm(),
            "{} {}",
            off.norm(),
            all.norm()
        );
        for roughness in &found.roughness(&whitening)[..2] {
            assert!((roughness / 0.09 - 1.0).abs() < 0.1, "{roughness}");
        }
    }

    #[test]
    fn without_walks_nothing_is_found() {
        let rough = Rough::new(0.3, 2, &mut ChaCha8Rng::seed_from_u64(5));
        assert!(Regression::new(&[], &rough.jacobian, &whitening()).is_none());
    }
}
