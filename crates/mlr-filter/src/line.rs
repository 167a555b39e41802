//! Straight lines through values.

/// A straight line fitted to values over time.
pub(crate) struct Line {
    pub(crate) slope: f64,
    /// Root mean square of the residual.
    pub(crate) error: f64,
}

impl Line {
    /// By least squares; without an error that counts where there are fewer than three values.
    pub(crate) fn through(times_s: &[f64], values: &[f64]) -> Self {
        let n = times_s.len() as f64;
        if times_s.len() < 3 {
            return Self {
                slope: 0.0,
                error: f64::INFINITY,
            };
        }
        let mean_s = times_s.iter().sum::<f64>() / n;
        let mean = values.iter().sum::<f64>() / n;
        let pairs = times_s.iter().zip(values);
        let (mut along, mut squares_s2, mut squares) = (0.0, 0.0, 0.0);
        for (time_s, value) in pairs {
            along += (time_s - mean_s) * (value - mean);
            squares_s2 += (time_s - mean_s).powi(2);
            squares += (value - mean).powi(2);
        }
        let slope = along / squares_s2.max(f64::MIN_POSITIVE);
        Self {
            slope,
            error: ((squares - slope * along).max(0.0) / n).sqrt(),
        }
    }
}
