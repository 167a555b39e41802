//! Laplace's approximation, where priors are standard normal.

use nalgebra::DMatrix;

/// Precision of the posterior: the curvature of minus the logarithm of the likelihood, and that of the
/// prior.
pub(crate) fn precision(mut curvature: DMatrix<f64>) -> DMatrix<f64> {
    for k in 0..curvature.ncols() {
        curvature[(k, k)] += 1.0;
    }
    curvature
}

/// Logarithm of the volume of the posterior of parameters over that of their prior, by the curvature of
/// minus the logarithm of the likelihood; minus infinity where a curvature is not finite.
pub(crate) fn ln_volume(curvature: DMatrix<f64>) -> f64 {
    let factors = precision(curvature).cholesky();
    factors.map_or(f64::NEG_INFINITY, |factors| -0.5 * factors.ln_determinant())
}

/// Covariance of the parameters by the same curvature; that of their prior where it has no inverse.
pub(crate) fn covariance(curvature: DMatrix<f64>) -> DMatrix<f64> {
    let p = curvature.ncols();
    precision(curvature)
        .try_inverse()
        .unwrap_or_else(|| DMatrix::identity(p, p))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_log_tells_narrows_the_posterior_and_what_it_does_not_leaves_it() {
        let curvature = DMatrix::from_diagonal(&nalgebra::DVector::from_vec(vec![3.0, 0.0]));
        assert!((ln_volume(curvature.clone()) + 2.0_f64.ln()).abs() < 1e-12);
        let covariance = covariance(curvature);
        assert!((covariance[(0, 0)] - 0.25).abs() < 1e-12);
        assert!((covariance[(1, 1)] - 1.0).abs() < 1e-12);
        assert_eq!(
            ln_volume(DMatrix::from_element(1, 1, f64::NAN)),
            f64::NEG_INFINITY
        );
    }
}
