//! How far the body swings, averaged over some gait cycles.

use std::collections::VecDeque;

/// The detector's fluctuations of the last seconds.
#[derive(Debug, Default)]
pub(super) struct RecentSwings(VecDeque<(f64, f64)>);

impl RecentSwings {
    /// The mean over the last `window_s`, this one included.
    pub(super) fn mean_with(&mut self, now_s: f64, fluctuation_deg: f64, window_s: f64) -> f64 {
        self.0.push_back((now_s, fluctuation_deg));
        self.0.retain(|(time_s, _)| now_s - time_s <= window_s);
        self.0.iter().map(|(_, swing_deg)| swing_deg).sum::<f64>() / self.0.len() as f64
    }
}

/// Whether the body swings so differently, averaged over some gait cycles, that
/// the damage must have changed: by a quarter and more than a degree.
pub(super) fn differs(swing_deg: f64, known_deg: f64) -> bool {
    (swing_deg - known_deg).abs() > (0.25 * known_deg).max(1.0)
}
