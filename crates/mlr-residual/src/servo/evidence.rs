//! ln p(recordings | effects): the parameters of the effects integrated out by Laplace's approximation.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::hypothesis::Hypothesis;
use crate::{
    laplace::{self, ln_volume},
    servo_effects::ServoEffect,
    statistics::{self, median},
};

/// Time over which the errors of a fitted servo are alike, s: the median integrated autocorrelation time
/// of the twelve recordings of `data/real/servo-xl330`, 0.16 to 8.9 s. Errors this far apart count as
/// independent.
const ERRORS_ALIKE_S: f64 = 0.65;
/// Prior probability that a servo has an effect: four of the library's nineteen. Assumed.
const PRESENT: f64 = 0.2;
/// Gain of the logarithm of the posterior density below which a fit has converged.
const CONVERGED: f64 = 0.05;
/// How far steps are held back, in units of the prior's precision (Levenberg).
const DAMPINGS: [f64; 4] = [0.0, 10.0, 100.0, 1000.0];

/// A hypothesis at its most probable parameters.
#[derive(Debug, Clone)]
pub(super) struct Fit<'a> {
    pub(super) hypothesis: Hypothesis<'a>,
    pub(super) z: DVector<f64>,
    residual: DVector<f64>,
    pub(super) jacobian: DMatrix<f64>,
    /// Logarithm of evidence times prior probability.
    pub(super) ln_weight: f64,
}

/// What turns the logarithm of the evidence of effects, whose parameters have standard normal priors,
/// into that of their weight, up to a constant.
fn ln_prior(hypothesis: &Hypothesis<'_>) -> f64 {
    let each = (PRESENT / (1.0 - PRESENT)).ln();
    hypothesis.effects.len() as f64 * each + hypothesis.ln_truncation()
}

/// The angles of each recording and its controller's effort, where they stand in a residual.
struct Signals(Vec<Signal>);

struct Signal {
    samples: Range<usize>,
    /// Errors that are independent of each other.
    independent: f64,
    /// Mean square that the resolution alone leaves.
    floor: f64,
    is_angle: bool,
}

impl Signals {
    fn of(hypothesis: &Hypothesis<'_>) -> Self {
        let mut next = 0;
        let mut signal = |samples: usize, seconds: f64, resolution: f64, is_angle: bool| {
            next += samples;
            Signal {
                samples: next - samples..next,
                independent: seconds / ERRORS_ALIKE_S,
                // Of a number that is rounded to steps, uniform over one.
                floor: resolution.powi(2) / 12.0,
                is_angle,
            }
        };
        let described = hypothesis.described();
        let mut signals = Vec::new();
        for recording in hypothesis.recordings() {
            let (samples, seconds) = (recording.times_s.len(), recording.duration_s());
            signals.push(signal(samples, seconds, recording.resolution_rad(), true));
            let efforts = described.effort_errors(recording).len();
            if let Some(largest) = described.bench.reference.load.filter(|_| efforts > 0) {
                let powered_s = seconds * efforts as f64 / samples as f64;
                signals.push(signal(efforts, powered_s, 1.0 / largest, false));
            }
        }
        Self(signals)
    }

    fn mean_squares<'s>(&'s self, residual: &'s DVector<f64>) -> impl Iterator<Item = f64> + 's {
        self.0.iter().map(|signal| {
            let errors = residual.rows_range(signal.samples.clone());
            errors.norm_squared() / errors.len().max(1) as f64 + signal.floor
        })
    }

    /// Logarithm of the likelihood, up to a constant: errors of each signal are normal with a scale
    /// of its own that is not known, each order of magnitude as probable as another.
    fn ln_likelihood(&self, residual: &DVector<f64>) -> f64 {
        let each = self.0.iter().zip(self.mean_squares(residual));
        each.map(|(signal, mean_square)| -0.5 * signal.independent * mean_square.ln())
            .sum()
    }

    /// The precision of each sample, such that samples count as many times as there are independent
    /// errors.
    fn precisions(&self, residual: &DVector<f64>) -> DVector<f64> {
        let mut precisions = DVector::zeros(residual.len());
        for (signal, mean_square) in self.0.iter().zip(self.mean_squares(residual)) {
            let share = signal.independent / signal.samples.len() as f64;
            precisions
                .rows_range_mut(signal.samples.clone())
                .fill(share / mean_square);
        }
        precisions
    }

    /// Curvature of minus the logarithm of the likelihood, and its slope.
    fn normal_equations(
        &self,
        residual: &DVector<f64>,
        jacobian: &DMatrix<f64>,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let precisions = self.precisions(residual);
        let mut weighted = jacobian.clone();
        for mut column in weighted.column_iter_mut() {
            column.component_mul_assign(&precisions);
        }
        (jacobian.tr_mul(&weighted), weighted.tr_mul(residual))
    }
}

impl<'a> Fit<'a> {
    /// Up to so many steps from these coordinates; `None` where the bench does not stay finite there.
    pub(super) fn from(hypothesis: Hypothesis<'a>, z: &DVector<f64>, steps: usize) -> Option<Self> {
        let z = hypothesis.within_bounds(z);
        let residual = hypothesis.residual(&z)?;
        let jacobian = hypothesis.jacobian(&z, &residual, 0..z.len());
        let ln_weight = f64::NEG_INFINITY;
        let mut fit = Self {
            hypothesis,
            z,
            residual,
            jacobian,
            ln_weight,
        };
        for _ in 0..steps {
            if !fit.step() {
                break;
            }
        }
        fit.ln_weight = fit.integrated();
        Some(fit)
    }

    /// A step of Gauss and Newton's method; whether it was worth while.
    fn step(&mut self) -> bool {
        if self.z.is_empty() {
            return false;
        }
        let signals = Signals::of(&self.hypothesis);
        let (curvature, slope) = signals.normal_equations(&self.residual, &self.jacobian);
        let here = signals.ln_likelihood(&self.residual) - 0.5 * self.z.norm_squared();
        let precision = laplace::precision(curvature);
        let tried = DAMPINGS.into_par_iter().filter_map(|damping| {
            let p = self.z.len();
            let damped = &precision + DMatrix::from_diagonal_element(p, p, damping);
            let step = damped.cholesky()?.solve(&(&slope - &self.z));
            let z = self.hypothesis.within_bounds(&(&self.z + step));
            let residual = self.hypothesis.residual(&z)?;
            let ln_posterior = signals.ln_likelihood(&residual) - 0.5 * z.norm_squared();
            Some((z, residual, ln_posterior))
        });
        let Some((z, residual, ln_posterior)) = tried.max_by(|a, b| a.2.total_cmp(&b.2)) else {
            return false;
        };
        if ln_posterior <= here {
            return false;
        }
        self.jacobian = self.hypothesis.jacobian(&z, &residual, 0..z.len());
        (self.z, self.residual) = (z, residual);
        ln_posterior > here + CONVERGED
    }

    /// Laplace's approximation here.
    fn integrated(&self) -> f64 {
        let signals = Signals::of(&self.hypothesis);
        let ln_posterior = signals.ln_likelihood(&self.residual) - 0.5 * self.z.norm_squared();
        let (curvature, _) = signals.normal_equations(&self.residual, &self.jacobian);
        ln_posterior + ln_volume(curvature) + ln_prior(&self.hypothesis)
    }

    /// Median over the recordings of the root mean square error, degrees.
    pub(super) fn median_error_deg(&self) -> f64 {
        let signals = Signals::of(&self.hypothesis);
        let angles = signals.0.iter().filter(|signal| signal.is_angle);
        let errors = angles.map(|signal| {
            let of_signal = self.residual.rows_range(signal.samples.clone());
            statistics::rms(of_signal.as_slice()).to_degrees()
        });
        median(errors.collect())
    }

    /// Covariance of the coordinates.
    pub(super) fn covariance(&self) -> DMatrix<f64> {
        let signals = Signals::of(&self.hypothesis);
        let (curvature, _) = signals.normal_equations(&self.residual, &self.jacobian);
        laplace::covariance(curvature)
    }

    /// What the linear model about these coordinates of an effect promises beside this fit: one run of
    /// the bench for each of its parameters, and one.
    pub(super) fn promise_with(
        &self,
        effect: &'static dyn ServoEffect,
        coordinates: &[f64],
    ) -> Option<Promise<'a>> {
        let larger = self.hypothesis.with(effect);
        let p = self.z.len();
        let all = self.z.iter().chain(coordinates).copied();
        let z = larger.within_bounds(&DVector::from_iterator(p + coordinates.len(), all));
        let residual = larger.residual(&z)?;
        let own = larger.jacobian(&z, &residual, p..z.len());
        let mut jacobian = self.jacobian.clone().insert_columns(p, own.ncols(), 0.0);
        jacobian.columns_mut(p, own.ncols()).copy_from(&own);
        Promise::new(larger, z, &residual, &jacobian)
    }

    /// What the linear model promises without one of the effects: one run of the bench.
    pub(super) fn promise_without(&self, left_out: usize) -> Option<Promise<'a>> {
        let (smaller, z) = self.hypothesis.without(left_out, &self.z);
        let columns = self.hypothesis.ranges().swap_remove(left_out);
        let jacobian = self
            .jacobian
            .clone()
            .remove_columns(columns.start, columns.len());
        let residual = smaller.residual(&z)?;
        Promise::new(smaller, z, &residual, &jacobian)
    }
}

/// The one with the greatest weight.
pub(super) fn likeliest<'a>(fits: impl IntoIterator<Item = Fit<'a>>) -> Option<Fit<'a>> {
    let by_weight = |a: &Fit<'_>, b: &Fit<'_>| a.ln_weight.total_cmp(&b.ln_weight);
    fits.into_iter().max_by(by_weight)
}

/// A hypothesis before it is fitted.
pub(super) struct Promise<'a> {
    pub(super) hypothesis: Hypothesis<'a>,
    /// Where its fit begins.
    pub(super) z: DVector<f64>,
    /// Logarithm of evidence times prior probability by its linear model.
    pub(super) ln_weight: f64,
}

impl<'a> Promise<'a> {
    fn new(
        hypothesis: Hypothesis<'a>,
        z: DVector<f64>,
        residual: &DVector<f64>,
        jacobian: &DMatrix<f64>,
    ) -> Option<Self> {
        let signals = Signals::of(&hypothesis);
        let (curvature, slope) = signals.normal_equations(residual, jacobian);
        let precision = laplace::precision(curvature.clone());
        let step = precision.cholesky()?.solve(&(slope - &z));
        let ln = |residual: &DVector<f64>, z: &DVector<f64>| {
            signals.ln_likelihood(residual) - 0.5 * z.norm_squared()
        };
        let there = ln(&(residual - jacobian * &step), &(&z + step));
        // A linear model may lead nowhere: where the fit begins counts as well.
        let best = there.max(ln(residual, &z));
        Some(Self {
            ln_weight: best + ln_volume(curvature) + ln_prior(&hypothesis),
            hypothesis,
            z,
        })
    }

    /// Fitted from where it begins, in up to so many steps.
    pub(super) fn fitted(self, steps: usize) -> Option<Fit<'a>> {
        Fit::from(self.hypothesis, &self.z, steps)
    }
}
