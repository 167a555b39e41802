//! How much error noise alone would leave.

/// Lengths of the stretches over which the error is averaged before the growth of its
/// random walk is read off, s. Vibration and kinks of the motion only add to what is
/// read, at some lengths more than at others, so that the least of them counts.
const STRETCHES_S: [f64; 3] = [0.25, 0.5, 1.0];
/// Square of the median deviation of a normal distribution in units of its variance.
const MEDIAN_SQUARE: f64 = 0.4549;

/// White noise of the reference and white noise of the rate, which the integral turns
/// into a random walk of the angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Noise {
    /// Standard deviation of the white part, degrees.
    white_deg: f64,
    /// Growth of the random walk's variance, deg²/s.
    walk_deg2_per_s: f64,
}

impl Noise {
    /// Reads both off how irregularly the error changes: the white part off the second
    /// differences of samples, the random walk off those of means over short stretches.
    /// A second difference does not see what a bias or a scale does while the sensor
    /// turns steadily, and the median does not see the moments when it turns back.
    pub(crate) fn of(error_deg: &[f64], period_s: f64) -> Self {
        // Two neighbouring steps of white noise differ by six times its variance.
        let white = median_square(&second_differences(error_deg)) / MEDIAN_SQUARE / 6.0;
        let growth = STRETCHES_S.map(|stretch_s| {
            let length = ((stretch_s / period_s).round() as usize).max(1);
            let stretches = error_deg.chunks_exact(length);
            let means: Vec<f64> = stretches
                .map(|stretch| stretch.iter().sum::<f64>() / length as f64)
                .collect();
            // Second differences of the means of a random walk vary by its growth over
            // one stretch. Few stretches tell it badly: an estimate is no less than zero, and
            // its standard error is added.
            let irregular = median_square(&second_differences(&means)) / MEDIAN_SQUARE;
            let standard_error = 3.0 / (means.len().max(1) as f64).sqrt() * irregular;
            let of_white = 6.0 * white / length as f64;
            ((irregular - of_white).max(0.0) + standard_error) / (length as f64 * period_s)
        });
        Self {
            white_deg: white.sqrt(),
            walk_deg2_per_s: growth.into_iter().fold(f64::INFINITY, f64::min),
        }
    }

    /// The smaller of two readings: what a model lacks only adds to them.
    pub(crate) fn least(self, other: Self) -> Self {
        Self {
            white_deg: self.white_deg.min(other.white_deg),
            walk_deg2_per_s: self.walk_deg2_per_s.min(other.walk_deg2_per_s),
        }
    }

    /// Root mean square that the error has by noise alone when the random walk has
    /// gone on for so long, degrees.
    pub(crate) fn floor_deg(&self, walk_s: f64) -> f64 {
        (self.white_deg.powi(2) + self.walk_deg2_per_s * walk_s).sqrt()
    }
}

fn second_differences(values: &[f64]) -> Vec<f64> {
    let triples = values.windows(3);
    triples.map(|v| v[2] - 2.0 * v[1] + v[0]).collect()
}

/// Square of the median of the absolute values.
fn median_square(values: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = values.iter().map(|value| value.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.get(sizes.len() / 2).map_or(0.0, |size| size * size)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt as _, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn white_noise_and_random_walk_are_told_apart() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut normal = |deviation: f64| {
            let sum: f64 = (0..12).map(|_| random.random::<f64>()).sum();
            deviation * (sum - 6.0)
        };
        let mut walk = 0.0;
        let error: Vec<f64> = (0..100_000)
            .map(|_| {
                walk += normal(0.01);
                walk + normal(0.05)
            })
            .collect();
        let noise = Noise::of(&error, 0.01);
        assert!((noise.white_deg - 0.05).abs() < 0.003, "{noise:?}");
        assert!((noise.walk_deg2_per_s - 0.01).abs() < 0.003, "{noise:?}");
    }
}
