//! When the sensor does not turn, told from the sensor alone.

use crate::SensorSignals;

/// For so long the signals must be still.
const WINDOW_S: f64 = 0.5;
/// Largest less smallest rate of a sensor at rest, °/s.
const MAX_RATE_RANGE_DPS: f64 = 1.5;
/// Zero-rate output that the data sheet allows (±20 °/s) and a margin.
const MAX_BIAS_DPS: f64 = 25.0;
/// Largest less smallest acceleration of a sensor at rest, g.
const MAX_ACCELERATION_RANGE_G: f64 = 0.05;

/// Whether the sensor has been still for the half second up to each sample. A turn
/// at a steady rate below 25 °/s about an upright axis looks the same.
pub(super) fn at_rest(signals: &SensorSignals) -> Vec<bool> {
    let mut limits = vec![(&signals.rate_dps, MAX_RATE_RANGE_DPS)];
    for along in signals.accelerations_g.iter().flatten() {
        limits.push((along, MAX_ACCELERATION_RANGE_G));
    }
    let mut still = vec![true; signals.len()];
    for (values, max_range) in limits {
        let mut from = 0;
        for i in 0..signals.len() {
            while signals.times_s[i] - signals.times_s[from] > WINDOW_S {
                from += 1;
            }
            let window = &values[from..=i];
            let (low, high) = window
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                    (low.min(*value), high.max(*value))
                });
            let covered = from > 0;
            still[i] &= covered && high - low <= max_range;
        }
    }
    for (still, rate) in still.iter_mut().zip(&signals.rate_dps) {
        *still &= rate.abs() <= MAX_BIAS_DPS;
    }
    still
}
