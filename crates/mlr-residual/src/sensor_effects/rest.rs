//! When the sensor does not turn, by its own signals alone.

use crate::SensorSignals;

/// For so long the signals must be still.
const WINDOW_S: f64 = 0.5;
/// Largest less smallest rate of a sensor at rest, °/s.
const MAX_RATE_RANGE_DPS: f64 = 1.5;
/// Zero-rate output that the data sheet allows (±20 °/s) and a margin.
const MAX_BIAS_DPS: f64 = 25.0;
/// Largest less smallest acceleration of a sensor at rest, g.
const MAX_ACCELERATION_RANGE_G: f64 = 0.05;

/// Rest from which on a bias can be read.
const MIN_REST_S: f64 = 1.0;

/// Mean rate while the sensor is at rest, °/s with the sign of the mounting; None where it rests
/// for less than a second in all.
pub(crate) fn rest_bias_dps(signals: &SensorSignals) -> Option<f64> {
    let rests = at_rest(signals);
    let resting = rests
        .iter()
        .zip(&signals.rate_dps)
        .filter(|(rest, _)| **rest);
    let (sum_dps, count) = resting.fold((0.0, 0_u32), |(sum, n), (_, rate)| (sum + rate, n + 1));
    let rest_s = f64::from(count) * signals.period_s();
    (rest_s >= MIN_REST_S).then(|| sum_dps / f64::from(count))
}

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
