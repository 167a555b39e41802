//! ln p(log | hypothesis) where walks are rough: by the mean of the walks about the most probable
//! parameters in place of a single one.

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
use crate::{laplace, statistics::median};

/// Walks of all hypotheses on a robot together that are drawn every time.
const DRAWS: usize = 96;
/// Of each at least.
const LEAST_DRAWS: usize = 12;
/// Times that walks are drawn, each time about the parameters that all so far make most probable.
const TIMES: usize = 3;
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
    hypotheses: Vec<Sampled<'w, 'a>>,
    of_means: &'w Observation<'w>,
    spread: Spread,
    /// For errors of single walks at first, then for those of the mean of all walks so far.
    whitening: Whitening,
    /// Change of the prediction per unit of each of the robot's own coordinates, as known before.
    known: &'w DMatrix<f64>,
    /// Every hypothesis takes its draws from the same: what differs is the hypothesis.
    generator: ChaCha8Rng,
}

/// What means of walks say of the hypotheses on a robot.
pub(crate) struct Averaged {
    /// In their order; `None` of a hypothesis most of whose neighbours do not walk.
    pub(crate) fits: Vec<Option<Fit>>,
    /// For errors of the means.
    pub(crate) whitening: Whitening,
    pub(crate) scatter: Option<Scatter>,
}

/// A hypothesis with its most probable parameters by the walks so far; `None` when most of them do not walk.
struct Sampled<'w, 'a> {
    walker: &'w Walker<'a>,
    fit: Option<Fit>,
    /// Takes out of coordinates those of the robot that an effect replaces.
    counting: DMatrix<f64>,
}

impl<'w, 'a> MeanWalks<'w, 'a> {
    /// Of these hypotheses about their fits to single walks, whose errors `whitening` is for; `known` has the
    /// sensitivities of the robot's own coordinates, by which robots of one make spread so far.
    pub(crate) fn new(
        fitted: impl IntoIterator<Item = (&'w Walker<'a>, &'w Fit)>,
        known: &'w DMatrix<f64>,
        spread: Spread,
        whitening: &Whitening,
        of_means: &'w Observation<'w>,
        generator: ChaCha8Rng,
    ) -> Self {
        let own = known.ncols();
        let hypotheses = fitted.into_iter().map(|(walker, fit)| {
            let mut jacobian = fit.jacobian.clone();
            jacobian.columns_mut(0, own).copy_from(known);
            let jacobian = walker.without_replaced(jacobian);
            let p = walker.dimension();
            Sampled {
                walker,
                fit: Some(walker.integrated(fit.walked.clone(), jacobian, whitening)),
                counting: walker.without_replaced(DMatrix::identity(p, p)),
            }
        });
        Self {
            hypotheses: hypotheses.collect(),
            of_means,
            spread,
            whitening: whitening.clone(),
            known,
            generator,
        }
    }

    /// How walks of the hypotheses scatter about their means; `None` where they do not walk.
    pub(crate) fn scatter(self) -> Option<Scatter> {
        let mut walks = self.without_walks();
        for (one, walks) in self.hypotheses.iter().zip(&mut walks) {
            walks.draws = self.drawn(one, 0, SCATTERED)?;
        }
        Some(Regression::new(&walks, self.known)?.scatter())
    }

    /// Draws walks, and fits their means.
    pub(crate) fn averaged(mut self) -> Averaged {
        let mut scatter = None;
        let mut walks = self.without_walks();
        let each = (DRAWS / self.hypotheses.len().max(1)).max(LEAST_DRAWS);
        for time in 0..TIMES {
            let drawn: Vec<Option<Vec<Draw>>> = self
                .hypotheses
                .par_iter()
                .map(|one| self.drawn(one, time, each))
                .collect();
            for ((one, walks), drawn) in self.hypotheses.iter_mut().zip(&mut walks).zip(drawn) {
                match drawn {
                    Some(drawn) => walks.draws.extend(drawn),
                    None => one.fit = None,
                }
            }
            let Some(regression) = Regression::new(&walks, self.known) else {
                break;
            };
            let scattered = regression.scatter();
            let of_means = self
                .of_means
                .whitening(self.spread, Compared::MeanOf(&scattered));
            let Some(of_means) = of_means else { break };
            self.whitening = of_means;
            scatter = Some(scattered);
            let fits: Vec<Option<Fit>> = (0..walks.len())
                .into_par_iter()
                .map(|k| self.most_probable(k, &regression))
                .collect();
            for (one, fit) in self.hypotheses.iter_mut().zip(fits) {
                one.fit = fit;
            }
        }
        Averaged {
            fits: self.hypotheses.into_iter().map(|one| one.fit).collect(),
            whitening: self.whitening,
            scatter,
        }
    }

    /// What is known of each hypothesis before any walk is drawn.
    fn without_walks(&self) -> Vec<Walks> {
        let own = self.known.ncols();
        let fits = self.hypotheses.iter().map(|one| one.fit.as_ref());
        fits.map(|fit| Walks {
            draws: Vec::new(),
            known: fit.map_or_else(
                || DMatrix::zeros(0, 0),
                |fit| fit.jacobian.columns_range(own..).clone_owned(),
            ),
        })
        .collect()
    }

    /// So many walks of the posterior of a hypothesis; `None` where fewer than half walk.
    fn drawn(&self, of: &Sampled<'_, '_>, time: usize, count: usize) -> Option<Vec<Draw>> {
        let fit = of.fit.as_ref()?;
        let normals = normals(of.walker.dimension(), &self.generator, time, count);
        let precision = laplace::precision(fit.curvature.clone());
        let upper = precision.cholesky()?.l().transpose();
        let draws: Vec<Draw> = normals
            .par_iter()
            .enumerate()
            .filter_map(|(k, normal)| {
                let mut z = &fit.walked.z + upper.solve_upper_triangular(normal)?;
                of.walker.clamp(&mut z);
                // Both of a pair have the same.
                let impacts = match k / 2 % 2 {
                    0 => Impacts::Rigid,
                    _ => Impacts::Compliant,
                };
                let walked = of.walker.walk_with_impacts(z, impacts)?;
                Some(Draw {
                    z: &of.counting * walked.z,
                    impacts,
                    residual: walked.residual,
                })
            })
            .collect();
        let enough = 2 * draws.len() >= normals.len();
        enough.then(|| self.without_those_apart(draws, &fit.jacobian))
    }

    /// Those whose distance from the median is usual, as far as the sensitivities do not say why: a few that
    /// tip over have nothing to do with the mean of those that walk.
    fn without_those_apart(&self, draws: Vec<Draw>, jacobian: &DMatrix<f64>) -> Vec<Draw> {
        let errors: Vec<DVector<f64>> = draws
            .iter()
            .map(|draw| {
                self.whitening
                    .apply_to(&(&draw.residual + jacobian * &draw.z))
            })
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

    /// The fit of a hypothesis where its mean walk is most probable.
    fn most_probable(&self, index: usize, regression: &Regression) -> Option<Fit> {
        let one = &self.hypotheses[index];
        let centre = &one.fit.as_ref()?.walked.z;
        let within_bounds = |z: &mut DVector<f64>| one.walker.clamp(z);
        let mean = regression.of(index);
        let whitening = &self.whitening;
        let roughness = regression.roughness(whitening);
        let found = mean.integrated(centre, &one.counting, within_bounds, whitening, roughness);
        Some(Fit {
            walked: one.walker.walk(found.z)?,
            residual: found.residual,
            jacobian: found.jacobian,
            curvature: found.curvature,
            ln_evidence: found.ln_evidence,
        })
    }
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
        generator.set_stream((time * pairs + pair) as u64);
        DVector::from_fn(dimension, |_, _| mlr_model::standard_normal(&mut generator))
    });
    drawn.flat_map(|normal| [-&normal, normal]).collect()
}

#[cfg(test)]
mod tests;
