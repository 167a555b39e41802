//! The chi-square distribution.

use std::f64::consts::FRAC_1_SQRT_2;

/// Probability that the sum of so many squared standard normal numbers exceeds `square`, by the
/// approximation of Wilson and Hilferty (1931): its cube root is nearly normal. 1 of no numbers.
pub(crate) fn chi_square_tail(square: f64, count: usize) -> f64 {
    if count == 0 {
        return 1.0;
    }
    let n = count as f64;
    let variance = 2.0 / (9.0 * n);
    let deviations = ((square / n).cbrt() - (1.0 - variance)) / variance.sqrt();
    0.5 * libm::erfc(deviations * FRAC_1_SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_are_those_of_published_tables() {
        // Quantiles of 95 % and 99.9 %.
        for (count, square, tail) in [
            (1, 3.841, 0.05),
            (5, 11.070, 0.05),
            (30, 43.773, 0.05),
            (5, 20.515, 0.001),
            (30, 59.703, 0.001),
        ] {
            let found = chi_square_tail(square, count);
            assert!(
                (found / tail - 1.0).abs() < 0.12,
                "{count} {square}: {found}"
            );
        }
    }

    #[test]
    fn more_is_less_probable_and_nothing_is_certain() {
        assert!(chi_square_tail(3.0, 2) > chi_square_tail(3.1, 2));
        assert!(chi_square_tail(0.0, 3) > 0.999);
        assert_eq!(chi_square_tail(9.0, 0), 1.0);
    }
}
