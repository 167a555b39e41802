//! Errors block by block, and whether they differ significantly.

use super::rms;

/// Mean squares of an error in blocks of equal length.
#[derive(Debug, Clone, Default)]
pub(crate) struct BlockErrors {
    /// Of the error itself, deg².
    pub(crate) level: Vec<f64>,
    /// Of the error less its mean over the block, deg²: what drift over longer times
    /// does not touch.
    pub(crate) within: Vec<f64>,
}

impl BlockErrors {
    /// Divides the error into blocks.
    pub(crate) fn new(error_deg: &[f64], blocks: usize) -> Self {
        let length = error_deg.len().div_ceil(blocks).max(1);
        let mut errors = Self::default();
        for block in error_deg.chunks(length) {
            let mean = block.iter().sum::<f64>() / block.len() as f64;
            let level = rms(block).powi(2);
            errors.level.push(level);
            errors.within.push((level - mean * mean).max(0.0));
        }
        errors
    }

    /// Root mean square of the error within the blocks, degrees.
    pub(crate) fn within_deg(&self) -> f64 {
        (self.within.iter().sum::<f64>() / self.within.len().max(1) as f64).sqrt()
    }
}

/// One-sided p-value of the exact sign-flip test on the gains `before - after`: the probability
/// of a sum as large if either sign of each gain were equally probable. With 15 blocks the
/// smallest is 2⁻¹⁵.
pub(crate) fn sign_flip_p_value(before: &[f64], after: &[f64]) -> f64 {
    let gains: Vec<f64> = before.iter().zip(after).map(|(b, a)| b - a).collect();
    let total: f64 = gains.iter().sum();
    if total <= 0.0 || !total.is_finite() {
        return 1.0;
    }
    let flips = 1_usize << gains.len().min(20);
    // Each step flips one sign (Gray code), so that a sum costs one addition. What
    // rounding adds up to must not count as less than the total.
    let tolerance = 1e-9 * gains.iter().map(|gain| gain.abs()).sum::<f64>();
    let mut signs = vec![1.0; gains.len()];
    let mut sum = total;
    let mut as_large = 1;
    for flip in 1..flips {
        let k = flip.trailing_zeros() as usize;
        sum -= 2.0 * signs[k] * gains[k];
        signs[k] = -signs[k];
        as_large += usize::from(sum >= total - tolerance);
    }
    as_large as f64 / flips as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gain_in_every_block_is_significant() {
        let before = [2.0; 15];
        assert!((sign_flip_p_value(&before, &[1.0; 15]) - 2.0_f64.powi(-15)).abs() < 1e-12);
        assert_eq!(sign_flip_p_value(&before, &[2.0; 15]), 1.0);
        assert_eq!(sign_flip_p_value(&before, &[3.0; 15]), 1.0);
    }

    #[test]
    fn a_gain_in_half_of_the_blocks_is_not() {
        let after: Vec<f64> = (0..15).map(|i| f64::from(i % 2)).collect();
        assert!(sign_flip_p_value(&[0.5; 15], &after) > 0.3);
    }

    #[test]
    fn blocks_tell_level_from_what_is_within() {
        let error: Vec<f64> = (0..3000).map(|i| 2.0 + f64::from(i % 2)).collect();
        let errors = BlockErrors::new(&error, 15);
        assert_eq!(errors.level.len(), 15);
        assert!((errors.level[3] - 6.5).abs() < 1e-9);
        assert!((errors.within_deg() - 0.5).abs() < 1e-9);
    }
}
