//! Nonlinear least squares by Levenberg and Marquardt's method, and intervals that
//! hold when errors are correlated.

use nalgebra::{DMatrix, DVector};

use crate::sensor_effects::Parameter;

/// Steps after which a fit that has not converged is taken as it is.
const MAX_STEPS: usize = 15;
/// Relative gain below which a fit has converged.
const CONVERGED: f64 = 1e-7;
/// Blocks on either side whose errors may be correlated with those of a block.
const NEIGHBOURS: usize = 3;
/// 95 % quantile, two-sided, of Student's t for 14 degrees of freedom: 15 blocks.
const T_95: f64 = 2.145;

/// Values that fit best, and how well they are known.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    pub(crate) values: Vec<f64>,
    /// Half the width of the 95 % interval of each value; infinite where the data
    /// do not determine it.
    pub(crate) half_width_95: Vec<f64>,
}

/// Minimises the sum of squares of `residual` over the parameters within their
/// bounds, from their starting values.
pub(crate) fn least_squares(
    parameters: &[Parameter],
    blocks: usize,
    residual: impl Fn(&[f64]) -> Vec<f64>,
) -> Fit {
    if parameters.iter().any(Parameter::is_fixed) {
        return with_fixed(parameters, blocks, &residual);
    }
    let mut values: Vec<f64> = parameters
        .iter()
        .map(Parameter::start_within_bounds)
        .collect();
    if parameters.is_empty() {
        return Fit {
            values,
            half_width_95: Vec::new(),
        };
    }
    let mut errors = residual(&values);
    let mut cost = square_sum(&errors);
    let mut damping = 1e-3;
    let mut jacobian = slopes(parameters, &values, &errors, &residual);
    for _ in 0..MAX_STEPS {
        let (normal, gradient) = normal_equations(&jacobian, &errors);
        let tried = step_within_bounds(parameters, &values, &normal, &gradient, damping);
        let tried_errors = tried.as_ref().map(|tried| residual(tried));
        match (tried, tried_errors) {
            (Some(tried), Some(tried_errors)) if square_sum(&tried_errors) < cost => {
                let gain = 1.0 - square_sum(&tried_errors) / cost;
                cost = square_sum(&tried_errors);
                values = tried;
                errors = tried_errors;
                damping = (damping * 0.2).max(1e-12);
                if gain < CONVERGED {
                    break;
                }
                jacobian = slopes(parameters, &values, &errors, &residual);
            }
            _ => {
                damping *= 8.0;
                if damping > 1e10 {
                    break;
                }
            }
        }
    }
    let half_width_95 = half_widths(parameters, blocks, &jacobian, &errors);
    Fit {
        values,
        half_width_95,
    }
}

/// The same where some parameters are known beforehand; their intervals are points.
fn with_fixed(
    parameters: &[Parameter],
    blocks: usize,
    residual: &dyn Fn(&[f64]) -> Vec<f64>,
) -> Fit {
    let expanded = |free: &[f64], fixed: &dyn Fn(&Parameter) -> f64| -> Vec<f64> {
        let mut free = free.iter().copied();
        parameters
            .iter()
            .map(|parameter| match parameter.is_fixed() {
                true => fixed(parameter),
                false => free.next().unwrap_or(parameter.start),
            })
            .collect()
    };
    let free: Vec<Parameter> = parameters
        .iter()
        .filter(|parameter| !parameter.is_fixed())
        .cloned()
        .collect();
    let start = Parameter::start_within_bounds;
    let fit = least_squares(&free, blocks, |values| residual(&expanded(values, &start)));
    Fit {
        values: expanded(&fit.values, &start),
        half_width_95: expanded(&fit.half_width_95, &|_| 0.0),
    }
}

/// Where a damped step leads. A parameter at a bound that the step would cross stays
/// there, and the step is taken anew for the others: were it only cut off, they would move as
/// if it had moved along with them. None where the equations cannot be solved.
fn step_within_bounds(
    parameters: &[Parameter],
    values: &[f64],
    normal: &DMatrix<f64>,
    gradient: &DVector<f64>,
    damping: f64,
) -> Option<Vec<f64>> {
    let mut free: Vec<usize> = (0..parameters.len()).collect();
    loop {
        let mut damped = normal.select_rows(&free).select_columns(&free);
        for k in 0..free.len() {
            damped[(k, k)] += damping * damped[(k, k)].max(f64::MIN_POSITIVE);
        }
        let step = damped.cholesky()?.solve(&gradient.select_rows(&free));
        let mut moved = values.to_vec();
        for (k, step) in free.iter().zip(step.iter()) {
            moved[*k] -= step * parameters[*k].step;
        }
        let crosses = |k: &usize| {
            let Parameter { lower, upper, .. } = parameters[*k];
            (values[*k] <= lower && moved[*k] < lower) || (values[*k] >= upper && moved[*k] > upper)
        };
        let before = free.len();
        free.retain(|k| !crosses(k));
        if free.len() == before {
            let bounded = moved.iter().zip(parameters);
            return Some(bounded.map(|(v, p)| v.clamp(p.lower, p.upper)).collect());
        }
    }
}

/// Change of every error per step of every parameter, parameter by parameter.
fn slopes(
    parameters: &[Parameter],
    values: &[f64],
    errors: &[f64],
    residual: impl Fn(&[f64]) -> Vec<f64>,
) -> Vec<Vec<f64>> {
    let column = |k: usize, parameter: &Parameter| -> Vec<f64> {
        // Away from the upper bound, into the interval.
        let step = if values[k] + parameter.step > parameter.upper {
            -parameter.step
        } else {
            parameter.step
        };
        let mut moved = values.to_vec();
        moved[k] += step;
        let direction = step.signum();
        let moved = residual(&moved);
        moved
            .iter()
            .zip(errors)
            .map(|(moved, here)| direction * (moved - here))
            .collect()
    };
    (0..).zip(parameters).map(|(k, p)| column(k, p)).collect()
}

fn normal_equations(jacobian: &[Vec<f64>], errors: &[f64]) -> (DMatrix<f64>, DVector<f64>) {
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let n = jacobian.len();
    let mut normal = DMatrix::zeros(n, n);
    for row in 0..n {
        for column in row..n {
            normal[(row, column)] = dot(&jacobian[row], &jacobian[column]);
            normal[(column, row)] = normal[(row, column)];
        }
    }
    let gradient = jacobian.iter().map(|column| dot(column, errors));
    (normal, DVector::from_iterator(n, gradient))
}

/// The errors of an integral are correlated over seconds, so that the usual
/// intervals would be far too narrow. The sandwich estimator over `blocks` blocks
/// and their neighbours (Newey and West, 1987) only needs errors further apart than
/// that to be independent.
fn half_widths(
    parameters: &[Parameter],
    blocks: usize,
    jacobian: &[Vec<f64>],
    errors: &[f64],
) -> Vec<f64> {
    let n = parameters.len();
    let (normal, _) = normal_equations(jacobian, errors);
    let Some(inverse) = normal.cholesky().map(|factors| factors.inverse()) else {
        return vec![f64::INFINITY; n];
    };
    let mut scores = Vec::new();
    let length = errors.len().div_ceil(blocks).max(1);
    for (index, block) in errors.chunks(length).enumerate() {
        let from = index * length;
        let score = DVector::from_iterator(
            n,
            jacobian.iter().map(|column| -> f64 {
                let column = &column[from..from + block.len()];
                column.iter().zip(block).map(|(c, e)| c * e).sum()
            }),
        );
        scores.push(score);
    }
    let mut meat = DMatrix::zeros(n, n);
    for (i, score) in scores.iter().enumerate() {
        for (lag, other) in scores[i..].iter().take(NEIGHBOURS + 1).enumerate() {
            let weight = 1.0 - lag as f64 / (NEIGHBOURS + 1) as f64;
            let product = score * other.transpose() * weight;
            meat += &product;
            if lag > 0 {
                meat += product.transpose();
            }
        }
    }
    let covariance = &inverse * meat * &inverse;
    let width = |(k, parameter): (usize, &Parameter)| {
        T_95 * covariance[(k, k)].max(0.0).sqrt() * parameter.step
    };
    parameters.iter().enumerate().map(width).collect()
}

fn square_sum(errors: &[f64]) -> f64 {
    let sum: f64 = errors.iter().map(|error| error * error).sum();
    if sum.is_finite() { sum } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_decay_is_found_and_its_interval_holds_the_truth() {
        let times: Vec<f64> = (0..3000).map(|i| f64::from(i) * 1e-3).collect();
        let noise = |i: usize| 0.02 * ((i * 7919 % 1000) as f64 / 500.0 - 1.0);
        let parameters = [
            Parameter::new("height", 1.0).step(1e-4).bounds(0.0, 10.0),
            Parameter::new("rate", 1.0).step(1e-4).bounds(0.0, 10.0),
        ];
        let fit = least_squares(&parameters, 15, |values| {
            let errors = times.iter().enumerate().map(|(i, t)| {
                values[0] * (-values[1] * t).exp() - 3.0 * (-0.5 * t).exp() - noise(i)
            });
            errors.collect()
        });
        for (k, truth) in [3.0, 0.5].into_iter().enumerate() {
            let error = (fit.values[k] - truth).abs();
            assert!(error < fit.half_width_95[k] + 1e-4, "{fit:?}");
            assert!(fit.half_width_95[k] < 0.02, "{fit:?}");
        }
    }

    #[test]
    fn a_bound_on_one_parameter_leaves_the_others_at_their_best() {
        // Nearly the same column twice, so that cutting the first off moves the second far.
        let column = |i: usize| (i as f64 * 0.37).sin();
        let twin = |i: usize| column(i) + 0.1 * (i as f64 * 0.11).cos();
        let error = |values: &[f64], i: usize| {
            values[0] * column(i) + values[1] * twin(i) - 2.0 * column(i) + 0.5 * twin(i)
        };
        let parameters = |upper| {
            [
                Parameter::new("first", 0.5).step(1e-3).bounds(0.0, upper),
                Parameter::new("second", 0.0).step(1e-3),
            ]
        };
        let fit = |upper| {
            let errors = |values: &[f64]| (0..300).map(|i| error(values, i)).collect();
            least_squares(&parameters(upper), 15, errors).values
        };
        let free = fit(10.0);
        assert!((free[0] - 2.0).abs() < 1e-6 && (free[1] + 0.5).abs() < 1e-6);
        let bounded = fit(1.0);
        // What is left of the first column, on the second.
        let sum = |f: &dyn Fn(usize) -> f64| (0..300).map(f).sum::<f64>();
        let best = sum(&|i| column(i) * twin(i)) / sum(&|i| twin(i) * twin(i)) - 0.5;
        assert_eq!(bounded[0], 1.0);
        assert!((bounded[1] - best).abs() < 1e-6, "{bounded:?}, best {best}");
    }

    #[test]
    fn bounds_hold() {
        let parameters = [Parameter::new("x", 0.0).step(1e-3).bounds(-1.0, 2.0)];
        let fit = least_squares(&parameters, 15, |values| vec![values[0] - 5.0; 30]);
        assert_eq!(fit.values, [2.0]);
    }
}
