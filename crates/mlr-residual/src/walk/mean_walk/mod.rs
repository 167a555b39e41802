//! ln p(log | hypothesis) where walks are rough: by the mean of the walks about the most probable
//! parameters in place of a single one.

mod equations;
mod linear_walk;
mod regression;

use mlr_model::Impacts;
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use self::regression::{Draw, Regression, Walks};
use super::{
    discrepancy::{Compared, Scatter, Spread},
    evidence::Fit,
    hypothesis::Walker,
    observation::{Observation, Whitening},
};
use crate::{Progress, laplace, statistics::median};

/// Walks of all hypotheses on a robot together that are drawn every time, where their mean is to be known well.
pub(crate) const DRAWS: usize = 96;
/// Of each at least.
const LEAST_DRAWS: usize = 12;
/// Times that walks are drawn, each time about the parameters that all so far make most probable.
pub(crate) const TIMES: usize = 3;
/// Walks by which it is found how they scatter, where no mean is taken.
const SCATTERED: usize = 48;
/// A walk that lies farther from the median than so many times the median distance has tipped, or gone
/// another way.
const APART: f64 = 3.0;

/// Hypotheses on one robot by the mean of their walks.
///
/// A walk is a linear function of its coordinates z and something rough that differs from walk to
/// walk, however near these are. What a walk leaves of the log is
///
/// ```text
/// r(z) = f − J z + e
/// ```
///
/// Half of the walks have rigid impacts, half compliant ones ([`Impacts`]): f is the mean of both, and half of
/// how they differ is part of what the mean gets wrong.
///
/// f of each hypothesis, and J, which all have in common as far as the robot's own parameters go, are
/// found by regression over walks that are drawn from the posterior of z, which is found from these in turn. The
/// evidence is that of the linear model f − J z: a simulated walk that comes near the log by chance counts
/// as one of many, and no longer search makes a hypothesis likelier. Simulators with rough likelihoods are
/// fitted by such means of summaries since Wood (2010), "Statistical inference for noisy nonlinear
/// ecological dynamic systems".
pub(crate) struct MeanWalks<'w, 'a> {
    hypotheses: Vec<Sampled<'a>>,
    /// Of each hypothesis.
    walks: Vec<Walks>,
    of_means: &'w Observation<'w>,
    spread: Spread,
    /// For errors of single walks at first, then for those of the mean, by how the walks of the first hypotheses
    /// scatter.
    whitening: Whitening,
    /// Change of the prediction per unit of each of the robot's own coordinates, as known before.
    known: DMatrix<f64>,
    /// Every hypothesis takes its draws from the same: what differs is the hypothesis.
    generator: ChaCha8Rng,
}

/// A hypothesis with its most probable parameters by the walks so far; `None` when most of them do not walk.
struct Sampled<'a> {
    walker: Walker<'a>,
    fit: Option<Fit>,
    /// Takes out of coordinates those of the robot that an effect replaces.
    counting: DMatrix<f64>,
}

impl<'w, 'a> MeanWalks<'w, 'a> {
    /// Of no hypothesis yet. `whitening` is for errors of single walks; `known` has the sensitivities of the
    /// robot's own coordinates, by which robots of one make spread so far.
    pub(crate) fn new(
        known: DMatrix<f64>,
        spread: Spread,
        whitening: Whitening,
        of_means: &'w Observation<'w>,
        generator: ChaCha8Rng,
    ) -> Self {
        Self {
            hypotheses: Vec::new(),
            walks: Vec::new(),
            of_means,
            spread,
            whitening,
            known,
            generator,
        }
    }

    /// How walks of one hypothesis scatter about their mean; `None` where they do not walk.
    pub(crate) fn scatter(mut self, walker: &Walker<'a>, fit: &Fit) -> Option<Scatter> {
        self.add(walker, fit);
        let each = self.hypotheses.iter().zip(&mut self.walks);
        for (one, walks) in each {
            walks.draws = one.drawn(&self.generator, &self.whitening, 0, SCATTERED)?;
        }
        self.scattered()
    }

    /// Draws walks of further hypotheses about their fits to single ones, and fits the means of all: those known
    /// before count by what the new walks tell of them, too. Of those known that the new ones are compared with, `anew`,
    /// walks are drawn again in place of the first ones: else one that was weighed when less was known of the robot
    /// would seem to fit worse. About `draws` walks are drawn every time, of all these together.
    ///
    /// What the means get wrong is found from the walks of the first hypotheses, and stays: of more walks it would be
    /// another covariance, and robots with many hypotheses would be weighed otherwise than those with few.
    ///
    /// `progress` advances each of [`TIMES`] times.
    pub(crate) fn average<'f>(
        &mut self,
        fitted: impl IntoIterator<Item = (&'f Walker<'a>, &'f Fit)>,
        anew: &[usize],
        draws: usize,
        progress: &dyn Progress,
    ) where
        'a: 'f,
    {
        let first = self.hypotheses.len();
        for (walker, fit) in fitted {
            self.add(walker, fit);
        }
        let drawn: Vec<usize> = anew
            .iter()
            .copied()
            .chain(first..self.hypotheses.len())
            .collect();
        for index in anew {
            self.walks[*index].draws.clear();
        }
        let each = (draws / drawn.len().max(1)).max(LEAST_DRAWS);
        for time in 0..TIMES {
            let draws: Vec<Option<Vec<Draw>>> = drawn
                .par_iter()
                .map(|index| {
                    self.hypotheses[*index].drawn(&self.generator, &self.whitening, time, each)
                })
                .collect();
            for (index, draws) in drawn.iter().zip(draws) {
                match draws {
                    Some(draws) => self.walks[*index].draws.extend(draws),
                    None => self.hypotheses[*index].fit = None,
                }
            }
            progress.advance();
            let is_last = time + 1 == TIMES;
            let is_fitted = |index: usize| is_last || drawn.contains(&index);
            if self.fit(is_fitted, first == 0).is_none() {
                break;
            }
        }
    }

    /// The fit of the mean of [`DRAWS`] walks every time where one hypothesis is the only one; `None` where most of its
    /// neighbours do not walk.
    pub(crate) fn average_of_one(
        &mut self,
        walker: &Walker<'a>,
        single: &Fit,
        progress: &dyn Progress,
    ) -> Option<Fit> {
        self.average([(walker, single)], &[], DRAWS, progress);
        self.fits().next().flatten().cloned()
    }

    /// The fit of each hypothesis in the order in which they were added; `None` of one most of whose neighbours do
    /// not walk.
    pub(crate) fn fits(&self) -> impl Iterator<Item = Option<&Fit>> {
        self.hypotheses.iter().map(|one| one.fit.as_ref())
    }

    /// For errors of the means.
    pub(crate) fn whitening(&self) -> &Whitening {
        &self.whitening
    }

    /// How the walks drawn so far scatter about their means; `None` where there is none.
    pub(crate) fn scattered(&self) -> Option<Scatter> {
        Some(Regression::new(&self.walks, &self.known, &self.whitening)?.scatter())
    }

    fn add(&mut self, walker: &Walker<'a>, fit: &Fit) {
        let own = self.known.ncols();
        let mut jacobian = fit.jacobian.clone();
        jacobian.columns_mut(0, own).copy_from(&self.known);
        let jacobian = walker.without_replaced(jacobian);
        let p = walker.dimension();
        self.walks.push(Walks {
            draws: Vec::new(),
            known: jacobian.columns_range(own..).clone_owned(),
        });
        self.hypotheses.push(Sampled {
            walker: walker.clone(),
            fit: Some(walker.integrated(fit.walked.clone(), jacobian, &self.whitening)),
            counting: walker.without_replaced(DMatrix::identity(p, p)),
        });
    }

    /// Fits the means of some hypotheses, where `is_scatter_new` for errors by how all walks so far scatter.
    fn fit(
        &mut self,
        is_fitted: impl Fn(usize) -> bool + Sync,
        is_scatter_new: bool,
    ) -> Option<()> {
        let regression = Regression::new(&self.walks, &self.known, &self.whitening)?;
        if is_scatter_new {
            let scatter = regression.scatter();
            let compared = Compared::MeanOf(&scatter);
            self.whitening = self.of_means.whitening(self.spread, compared)?;
        }
        let whitening = &self.whitening;
        let each = self.hypotheses.par_iter_mut().enumerate();
        each.filter(|(index, _)| is_fitted(*index))
            .for_each(|(index, one)| {
                one.fit = one.most_probable(index, &regression, whitening);
            });
        Some(())
    }
}

impl Sampled<'_> {
    /// So many walks of its posterior; `None` where fewer than half walk.
    fn drawn(
        &self,
        generator: &ChaCha8Rng,
        whitening: &Whitening,
        time: usize,
        count: usize,
    ) -> Option<Vec<Draw>> {
        let fit = self.fit.as_ref()?;
        let normals = normals(self.walker.dimension(), generator, time, count);
        let precision = laplace::precision(fit.curvature.clone());
        let upper = precision.cholesky()?.l().transpose();
        let draws: Vec<Draw> = normals
            .par_iter()
            .enumerate()
            .filter_map(|(k, normal)| {
                let mut z = &fit.walked.z + upper.solve_upper_triangular(normal)?;
                self.walker.clamp(&mut z);
                // Both of a pair have the same.
                let impacts = match k / 2 % 2 {
                    0 => Impacts::Rigid,
                    _ => Impacts::Compliant,
                };
                let walked = self.walker.walk_with_impacts(z, impacts)?;
                Some(Draw {
                    z: &self.counting * walked.z,
                    impacts,
                    residual: walked.residual,
                })
            })
            .collect();
        let enough = 2 * draws.len() >= normals.len();
        enough.then(|| without_those_apart(draws, &fit.jacobian, whitening))
    }

    /// The fit where the mean walk, which regression has as that of this index, is most probable.
    fn most_probable(
        &self,
        index: usize,
        regression: &Regression,
        whitening: &Whitening,
    ) -> Option<Fit> {
        let centre = &self.fit.as_ref()?.walked.z;
        let within_bounds = |z: &mut DVector<f64>| self.walker.clamp(z);
        let mean = regression.of(index);
        let roughness = regression.roughness(whitening);
        let found = mean.integrated(centre, &self.counting, within_bounds, whitening, roughness);
        Some(Fit {
            walked: self.walker.walk(found.z)?,
            residual: found.residual,
            jacobian: found.jacobian,
            curvature: found.curvature,
            ln_evidence: found.ln_evidence,
        })
    }
}

/// Those whose distance from the median is usual, as far as the sensitivities do not say why: a few that
/// tip over have nothing to do with the mean of those that walk.
fn without_those_apart(
    draws: Vec<Draw>,
    jacobian: &DMatrix<f64>,
    whitening: &Whitening,
) -> Vec<Draw> {
    let errors: Vec<DVector<f64>> = draws
        .iter()
        .map(|draw| whitening.apply_to(&(&draw.residual + jacobian * &draw.z)))
        .collect();
    let rows = errors.first().map_or(0, |error| error.len());
    let middle = DVector::from_fn(rows, |row, _| {
        median(errors.iter().map(|error| error[row]).collect())
    });
    let distances: Vec<f64> = errors
        .iter()
        .map(|error| (error - &middle).norm())
        .collect();
    let farthest = APART * median(distances.clone());
    let each = draws.into_iter().zip(distances);
    each.filter(|(_, distance)| *distance <= farthest)
        .map(|(draw, _)| draw)
        .collect()
}

/// Standard normal draws in pairs of opposite sign: what is odd in them has no chance. Each pair is
/// a stream of its own, so that hypotheses of several dimensions have the first coordinates in common.
fn normals(
    dimension: usize,
    generator: &ChaCha8Rng,
    time: usize,
    count: usize,
) -> Vec<DVector<f64>> {
    let pairs = count.div_ceil(2);
    let drawn = (0..pairs).map(|pair| {
        let mut generator = generator.clone();
        generator.set_stream(((time as u64) << 32) + pair as u64);
        DVector::from_fn(dimension, |_, _| mlr_model::standard_normal(&mut generator))
    });
    drawn.flat_map(|normal| [-&normal, normal]).collect()
}

#[cfg(test)]
mod tests;
