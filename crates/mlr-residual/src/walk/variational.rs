//! ln p(log | hypothesis) where walks are rough: a lower bound that looks at the whole posterior in place of
//! its highest point.

use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::{
    evidence::{Fit, LinearModel, Step, curvature, ln_posterior},
    hypothesis::{Walked, Walker},
    observation::Whitening,
};
use crate::laplace::{self, ln_volume};

/// Walks that each expectation is taken over.
const DRAWS: usize = 24;
/// Times that the Gaussian is moved to where its own draws say that the posterior is.
const MOVES: usize = 2;

/// A Gaussian about the walk of a hypothesis, with what the hypothesis is worth by it.
struct Gaussian {
    centre: Walked,
    jacobian: DMatrix<f64>,
    curvature: DMatrix<f64>,
    /// A lower bound of the logarithm of the evidence, but for the chance of the draws.
    ln_bound: f64,
    /// Those that it counts.
    draws: Vec<Draw>,
}

/// A walk of the Gaussian's.
struct Draw {
    /// In standard deviations of the Gaussian.
    normal: DVector<f64>,
    /// From its centre.
    step: DVector<f64>,
    residual: DVector<f64>,
}

impl Walker<'_> {
    /// The evidence of a fit by a variational bound, at the Gaussian of the best of a few bounds.
    ///
    /// For any density q of the parameters z,
    ///
    /// ```text
    /// ln p(log | h) ≥ E_q[ln p(log, z | h) − ln q(z)]
    /// ```
    ///
    /// with equality where q is the posterior. q is Laplace's approximation: where the walk answers
    /// linearly, the bound is its evidence. Where it does not, a simulated walk that comes near the log by
    /// chance, at one point among many, counts by its share of the posterior, and no longer search makes a
    /// hypothesis likelier. The Gaussian is moved by Gauss and Newton's method on the mean of its own walks,
    /// which is smooth where single walks are not.
    ///
    /// Every hypothesis takes its draws from the same `generator`: what differs is the hypothesis.
    pub(crate) fn bounded(&self, fit: Fit, whitening: &Whitening, generator: &ChaCha8Rng) -> Fit {
        let normals = normals(self.dimension(), &mut generator.clone());
        let mut best: Option<Gaussian> = None;
        let mut centre = fit.walked.clone();
        // A fit may have its sensitivities from another hypothesis: draws would go astray.
        let mut jacobian = self.jacobian(&centre);
        for moves in 0..=MOVES {
            let Some(here) = self.gaussian(centre, jacobian, whitening, &normals) else {
                break;
            };
            let next = (moves < MOVES)
                .then(|| self.moved(&here, whitening))
                .flatten();
            if best
                .as_ref()
                .is_none_or(|best| here.ln_bound > best.ln_bound)
            {
                best = Some(here);
            }
            let Some(next) = next else { break };
            (centre, jacobian) = next;
        }
        match best {
            Some(best) => Fit {
                walked: best.centre,
                jacobian: best.jacobian,
                curvature: best.curvature,
                ln_evidence: best.ln_bound,
            },
            // None of its neighbours walks.
            None => Fit {
                ln_evidence: f64::NEG_INFINITY,
                ..fit
            },
        }
    }

    /// The Gaussian of Laplace's approximation about this walk; `None` where no draw from it walks.
    fn gaussian(
        &self,
        centre: Walked,
        jacobian: DMatrix<f64>,
        whitening: &Whitening,
        normals: &[DVector<f64>],
    ) -> Option<Gaussian> {
        let squares = whitening.squares(&centre.residual);
        let (_, precisions) = whitening.ln_density(squares, centre.residual.len());
        let curvature = curvature(whitening, &whitening.apply(&jacobian), precisions);
        let (draws, ln_bound) = bound(&curvature, normals, |step| {
            let mut z = &centre.z + step;
            self.clamp(&mut z);
            let step = &z - &centre.z;
            let walked = self.walk(z)?;
            Some((ln_posterior(whitening, &walked), step, walked.residual))
        })?;
        Some(Gaussian {
            ln_bound,
            draws,
            centre,
            jacobian,
            curvature,
        })
    }

    /// Where a Gaussian's own draws say that the posterior is, with sensitivities in the mean over them.
    fn moved(&self, of: &Gaussian, whitening: &Whitening) -> Option<(Walked, DMatrix<f64>)> {
        let count = of.draws.len() as f64;
        let n = of.centre.residual.len();
        let mut residual = DVector::zeros(n);
        for draw in &of.draws {
            residual += (&draw.residual + &of.jacobian * &draw.step) / count;
        }
        // Ridge regression of what the sensitivities miss, in standard deviations of the Gaussian: as much
        // is believed of it as of one standard deviation in every coordinate.
        let p = self.dimension();
        let mut missed = DMatrix::zeros(n, p);
        let mut squares = DMatrix::identity(p, p) * p as f64;
        for draw in &of.draws {
            let left = &residual - &draw.residual - &of.jacobian * &draw.step;
            missed += left * draw.normal.transpose();
            squares += &draw.normal * draw.normal.transpose();
        }
        let upper = laplace::precision(of.curvature.clone())
            .cholesky()?
            .l()
            .transpose();
        // Per standard deviation, then per coordinate: a normal is the upper factor times a step.
        let per_normal = squares.cholesky()?.solve(&missed.transpose()).transpose();
        let jacobian = &of.jacobian + per_normal * upper;
        let model = LinearModel {
            residual: whitening.apply_to(&residual),
            coordinates: of.centre.z.clone(),
            jacobian: whitening.apply(&jacobian),
            held: 0,
        };
        let mut z = &of.centre.z + model.step(whitening, Step::Damped(0.0));
        self.clamp(&mut z);
        Some((self.walk(z)?, jacobian))
    }
}

/// The draws of the Gaussian of this curvature that count, and the bound by them: `at` says for a step from
/// its centre the logarithm of the posterior density, the step within bounds, and the residual. `None` where
/// fewer than half of the draws have any.
fn bound(
    curvature: &DMatrix<f64>,
    normals: &[DVector<f64>],
    at: impl Fn(DVector<f64>) -> Option<(f64, DVector<f64>, DVector<f64>)> + Sync,
) -> Option<(Vec<Draw>, f64)> {
    let precision = laplace::precision(curvature.clone());
    let upper = precision.clone().cholesky()?.l().transpose();
    let draws: Vec<(f64, Draw)> = normals
        .par_iter()
        .filter_map(|normal| {
            let (ln_posterior, step, residual) = at(upper.solve_upper_triangular(normal)?)?;
            // What ln q has beside its constant has a known mean: its chance is taken out.
            let ln_ratio = ln_posterior + 0.5 * step.dot(&(&precision * &step));
            let normal = normal.clone();
            let draw = Draw {
                normal,
                step,
                residual,
            };
            Some((ln_ratio, draw))
        })
        .collect();
    let (draws, ln_mean) = kept(draws, normals.len())?;
    Some((draws, ln_mean + ln_volume(curvature.clone())))
}

/// The part of a Gaussian's draws for which its bound is greatest, and what that adds to the bound.
///
/// q may be the Gaussian on a part of its mass: with k of n draws the bound is their mean and ln(k/n). What
/// tips over is left out so. The part is at least half: else it would be a lucky walk again. `None` where
/// fewer draws walk.
fn kept<T>(mut draws: Vec<(f64, T)>, all: usize) -> Option<(Vec<T>, f64)> {
    draws.retain(|(ln, _)| ln.is_finite());
    draws.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let mut sum = 0.0;
    let bounds = draws.iter().enumerate().map(|(index, (ln, _))| {
        sum += ln;
        let count = index as f64 + 1.0;
        (index + 1, sum / count + (count / all as f64).ln())
    });
    let (count, bound) = bounds
        .filter(|(count, _)| 2 * count >= all)
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    draws.truncate(count);
    Some((draws.into_iter().map(|(_, draw)| draw).collect(), bound))
}

/// Standard normal draws in pairs of opposite sign: what is odd in them has no chance.
fn normals(dimension: usize, generator: &mut ChaCha8Rng) -> Vec<DVector<f64>> {
    let drawn: Vec<DVector<f64>> = (0..DRAWS / 2)
        .map(|_| DVector::from_fn(dimension, |_, _| mlr_model::standard_normal(generator)))
        .collect();
    drawn
        .into_iter()
        .flat_map(|normal| [-&normal, normal])
        .collect()
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;

    use super::*;
    use crate::ln_mean;

    /// Of two coordinates, one of which the log determines ten times better than its prior.
    fn curvature() -> DMatrix<f64> {
        DMatrix::from_row_slice(2, 2, &[99.0, 3.0, 3.0, 0.5])
    }

    fn smooth(step: &DVector<f64>) -> f64 {
        -7.0 - 0.5 * step.dot(&(laplace::precision(curvature()) * step))
    }

    fn bound_of(ln_posterior: impl Fn(&DVector<f64>) -> f64 + Sync) -> f64 {
        let normals = normals(2, &mut ChaCha8Rng::seed_from_u64(1));
        let at = |step: DVector<f64>| Some((ln_posterior(&step), step, DVector::zeros(0)));
        bound(&curvature(), &normals, at).unwrap().1
    }

    /// Its integral over the coordinates by the midpoint rule, over that of their prior.
    fn ln_evidence(ln_posterior: impl Fn(&DVector<f64>) -> f64) -> f64 {
        const N: usize = 1200;
        let place = |k: usize, half: f64| half * ((2 * k + 1) as f64 / N as f64 - 1.0);
        let (width, height) = (1.2, 8.0);
        let each = (0..N * N).map(|k| {
            ln_posterior(&DVector::from_vec(vec![
                place(k % N, width),
                place(k / N, height),
            ]))
        });
        let area = 4.0 * width * height;
        ln_mean(each, N * N) + (area / std::f64::consts::TAU).ln()
    }

    #[test]
    fn the_bound_is_the_evidence_where_the_posterior_is_the_gaussian() {
        let exact = ln_evidence(smooth);
        assert!((exact - (-7.0 + ln_volume(curvature()))).abs() < 1e-3);
        assert!((bound_of(smooth) - exact).abs() < 1e-3);
    }

    #[test]
    fn a_walk_that_is_near_by_chance_does_not_raise_the_bound() {
        // Hits the log at one point of the many that a long search looks at.
        let lucky = |step: &DVector<f64>| smooth(step) + 12.0 * (-1e4 * step.norm_squared()).exp();
        let laplace = lucky(&DVector::zeros(2)) + ln_volume(curvature());
        let exact = ln_evidence(lucky);
        assert!(laplace > exact + 5.0, "{laplace} {exact}");
        assert!((bound_of(lucky) - bound_of(smooth)).abs() < 1e-6);
    }

    #[test]
    fn the_bound_of_a_rough_posterior_lies_below_its_evidence() {
        let rough =
            |step: &DVector<f64>| smooth(step) + (300.0 * step[0]).sin() + (90.0 * step[1]).cos();
        let (bound, exact) = (bound_of(rough), ln_evidence(rough));
        assert!(bound < exact && bound > exact - 2.0, "{bound} {exact}");
    }

    #[test]
    fn what_tips_over_is_left_out_with_its_share_of_the_posterior() {
        let draws = |tipped: usize| -> Vec<(f64, ())> {
            let ln = |k| if k < tipped { -1700.0 } else { -3.0 };
            (0..DRAWS).map(|k| (ln(k), ())).collect()
        };
        let (left, ln) = kept(draws(0), DRAWS).unwrap();
        assert_eq!((left.len(), ln), (DRAWS, -3.0));
        let (left, ln) = kept(draws(2), DRAWS).unwrap();
        assert_eq!(left.len(), DRAWS - 2);
        let share: f64 = (DRAWS - 2) as f64 / DRAWS as f64;
        assert!((ln - (-3.0 + share.ln())).abs() < 1e-12);
        // Most of it tips over: the rest alone is no posterior.
        let (left, ln) = kept(draws(DRAWS - 3), DRAWS).unwrap();
        assert!(left.len() == DRAWS / 2 && ln < -1000.0);
        // The same where it does not walk at all.
        assert!(kept(draws(0)[..DRAWS / 2 - 1].to_vec(), DRAWS).is_none());
    }
}
