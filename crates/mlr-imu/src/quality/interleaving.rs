//! Rows that come from two sensors in turn.

use super::{Finding, FindingKind, Severity, rows::Rows};

/// From one sample to the next a signal changes at most as far as to the one after, white
/// noise as far, a smooth motion half as far. Twice as far is to and fro.
const TO_AND_FRO: f64 = 2.0;
/// Channels that must do so.
const CHANNELS: usize = 2;
/// Mean speed of roll and pitch, averaged over a walk, that no walking robot has: legs
/// that fall swing the body by 25° twice a second.
const LARGEST_SPEED_DPS: f64 = 250.0;
/// An average over less than a gait cycle is none.
const SHORTEST_S: f64 = 1.0;

/// Channels that jump to and fro from row to row.
pub(super) fn alternating(rows: &Rows<'_>) -> Option<Finding> {
    let alternate: Vec<&'static str> = rows
        .channels()
        .iter()
        .filter(|channel| {
            let next = median_change(&channel.values, 1);
            let after = median_change(&channel.values, 2);
            next > TO_AND_FRO * after && next > least_change(channel.name)
        })
        .map(|channel| channel.name)
        .collect();
    (alternate.len() >= CHANNELS).then(|| {
        rows.finding(FindingKind::Interleaved, Severity::Useless, format!(
                "{} jump to and fro from row to row: the log holds the rows of two sensors in turn, \
                 expected those of one",
                alternate.join(", ")
            ), None)
    })
}

/// Changes from row to row that are more than noise: in rad of angles, rad/s of rates, m/s² of
/// accelerations, each some times the noise of an MPU6050.
fn least_change(channel: &str) -> f64 {
    match channel.as_bytes() {
        [b'g', _] => 0.01,
        [b'a', _] => 0.15,
        _ => 0.001,
    }
}

fn median_change(values: &[f64], lag: usize) -> f64 {
    let mut changes: Vec<f64> = values
        .iter()
        .zip(values.iter().skip(lag))
        .map(|(a, b)| (b - a).abs())
        .collect();
    if changes.is_empty() {
        return 0.0;
    }
    let middle = changes.len() / 2;
    *changes.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Roll or pitch that never rests.
pub(super) fn restless(rows: &Rows<'_>) -> Option<Finding> {
    let walking = rows.walking();
    let duration_s =
        rows.times_s.get(walking.end.checked_sub(1)?)? - rows.times_s.get(walking.start)?;
    if duration_s < SHORTEST_S {
        return None;
    }
    let angles = rows.oriented_rad;
    [("roll", &angles.roll), ("pitch", &angles.pitch)]
        .into_iter()
        .find_map(|(name, values)| {
            let path_rad: f64 = values[walking.clone()]
                .windows(2)
                .map(|pair| (pair[1] - pair[0]).abs())
                .sum();
            let speed_dps = path_rad.to_degrees() / duration_s.max(1e-9);
            (speed_dps > LARGEST_SPEED_DPS).then(|| {
                rows.finding(FindingKind::Impossible, Severity::Useless, format!(
                        "{name} changes by {speed_dps:.0}° a second all the time: no body moves like \
                         that"
                    ), None)
    })
        })
}
