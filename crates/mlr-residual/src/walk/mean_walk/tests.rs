//! Linear walks that are rough, and their draws.

use mlr_model::{Gait, Impacts, LostLinks, Morphology, Robot, SimulationSettings};
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

use super::{
    DRAWS, MeanWalks, normals,
    regression::{Draw, Walks},
};
use crate::{
    walk::{
        Discrepancy, NuisancePrior, NuisanceSettings, WalkModel,
        discrepancy::Compared,
        evidence::Fit,
        hypothesis::{Hypothesis, Placement, Walker},
        observation::{Observation, Whitening, tests},
        record::tests::level_record,
    },
    walk_effects::{Place, find},
};

pub(super) fn whitening() -> Whitening {
    tests::whitening(&Discrepancy::default())
}

/// A robot whose walks are a linear function of its coordinates, and each a little off it.
pub(super) struct Rough {
    /// What the mean walk leaves of the log where all coordinates are 0.
    pub(super) at_zero: DVector<f64>,
    pub(super) jacobian: DMatrix<f64>,
    /// Makes errors of usual scale of standard normal ones.
    factor: DMatrix<f64>,
    roughness: f64,
}

impl Rough {
    /// Sensitivities fall from one coordinate to the next: some count, some do not.
    pub(super) fn new(roughness: f64, coordinates: usize, random: &mut ChaCha8Rng) -> Self {
        let rows = tests::rows();
        let whitened = whitening().apply(&DMatrix::identity(rows, rows));
        let factor = whitened.try_inverse().unwrap();
        let white = |_: usize, _: usize| mlr_model::standard_normal(random);
        let mut errors = DMatrix::from_fn(rows, coordinates + 1, white);
        for (k, mut column) in errors.column_iter_mut().enumerate() {
            column *= 0.5 * 0.7_f64.powi(k as i32);
        }
        let errors = &factor * errors;
        Self {
            at_zero: errors.column(0).clone_owned(),
            jacobian: errors.columns(1, coordinates).clone_owned(),
            factor,
            roughness,
        }
    }

    /// What the mean walk leaves of the log, so much of the first sensitivity more.
    pub(super) fn mean(&self, z: &DVector<f64>, shift: f64) -> DVector<f64> {
        &self.at_zero - &self.jacobian * z + shift * self.jacobian.column(0)
    }

    fn error(&self, random: &mut ChaCha8Rng) -> DVector<f64> {
        let white = DVector::from_fn(self.factor.ncols(), |_, _| {
            mlr_model::standard_normal(random)
        });
        self.roughness * &self.factor * white
    }

    /// So many walks about where all coordinates are 0, of a hypothesis without effects.
    pub(super) fn walks(&self, count: usize, shift: f64, random: &mut ChaCha8Rng) -> Walks {
        let draws = (0..count).map(|k| {
            let z = DVector::from_fn(self.jacobian.ncols(), |_, _| {
                mlr_model::standard_normal(random)
            });
            Draw {
                impacts: if k % 2 == 0 {
                    Impacts::Rigid
                } else {
                    Impacts::Compliant
                },
                residual: self.mean(&z, shift) + self.error(random),
                z,
            }
        });
        Walks {
            draws: draws.collect(),
            known: DMatrix::zeros(self.at_zero.len(), 0),
        }
    }

    /// Sensitivities as differences of two walks show them.
    pub(super) fn differences(&self, random: &mut ChaCha8Rng) -> DMatrix<f64> {
        let mut jacobian = self.jacobian.clone();
        for mut column in jacobian.column_iter_mut() {
            column += self.error(random) - self.error(random);
        }
        jacobian
    }
}

#[test]
fn draws_come_in_pairs_and_agree_where_hypotheses_have_coordinates_in_common() {
    let generator = ChaCha8Rng::seed_from_u64(0);
    let (few, many) = (normals(3, &generator, 1, 8), normals(5, &generator, 1, 8));
    assert_eq!((few.len(), many.len()), (8, 8));
    for (few, many) in few.iter().zip(&many) {
        assert!((few - many.rows(0, 3)).norm() < 1e-12);
    }
    let sum: DVector<f64> = few.iter().sum();
    assert!(sum.norm() < 1e-12);
    // Not the same the next time.
    assert!((&normals(3, &generator, 2, 8)[0] - &few[0]).norm() > 0.1);
}

/// What slippery ground adds to the evidence of a robot is the same whether both are weighed together or one after the
/// other.
#[test]
fn hypotheses_that_are_added_later_are_weighed_for_the_same_errors() {
    let robot = Robot::jethexa();
    let morphology = Morphology::parse_legs_lost("4,5", &robot.layout()).unwrap();
    let nominal = WalkModel::nominal(robot, Gait::tripod(), SimulationSettings::default());
    let record = level_record();
    let observation = Observation::new(&record, &Discrepancy::default(), 1.0);
    let of_means = Observation::new(&record, &Discrepancy::of_means(), 1.0);
    let prior = NuisancePrior::new(&NuisanceSettings::default(), &nominal);
    let walker = |effects: Vec<Placement>| {
        let hypothesis = Hypothesis {
            morphology: morphology.clone(),
            lost_links: LostLinks::Absent,
            effects,
        };
        Walker::new(hypothesis, &observation, &prior, &nominal)
    };
    let slippery = Placement {
        effect: find("friction").unwrap(),
        place: Place::Robot,
    };
    let walkers = [walker(vec![]), walker(vec![slippery])];
    let jacobian = {
        let bare = &walkers[0];
        bare.jacobian(&bare.walk(DVector::zeros(bare.dimension())).unwrap())
    };
    let spread = walkers[0].spread(&jacobian);
    let whitening = observation.whitening(spread, Compared::Walk).unwrap();
    let fit = |walker: &Walker<'_>| -> Fit {
        let walked = walker.walk(DVector::zeros(walker.dimension())).unwrap();
        walker.begun(walked, &jacobian, &whitening)
    };
    let fits = walkers.each_ref().map(fit);
    let averaged = |groups: &[&[usize]]| -> Vec<f64> {
        let generator = ChaCha8Rng::seed_from_u64(0);
        let (known, whitening) = (jacobian.clone(), whitening.clone());
        let mut walks = MeanWalks::new(known, spread, whitening, &of_means, generator);
        for group in groups {
            let weighed: Vec<usize> = (0..walks.fits().count()).collect();
            let fitted = group.iter().map(|k| (&walkers[*k], &fits[*k]));
            walks.average(fitted, &weighed, DRAWS, &());
        }
        walks.fits().map(|fit| fit.unwrap().ln_evidence).collect()
    };
    let together = averaged(&[&[0, 1]]);
    let in_turn = averaged(&[&[0], &[1]]);
    let gain = |of: &[f64]| of[1] - of[0];
    assert!(
        (gain(&in_turn) - gain(&together)).abs() < 0.5,
        "{in_turn:?} {together:?}"
    );
    // The control: weighed apart, each for the errors by how its own walks scatter, they differ by that.
    let apart = [averaged(&[&[0]])[0], averaged(&[&[1]])[0]];
    assert!((gain(&apart) - gain(&together)).abs() > 3.0, "{apart:?}");
}
