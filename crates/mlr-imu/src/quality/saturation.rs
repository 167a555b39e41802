//! Values that are cut off at the end of a range.

use super::{Finding, FindingKind, Severity, rows::Rows};

/// An extreme that is met this many times as often as the values just below it is the end
/// of a range: without one, extremes are rare.
const PILED_UP: f64 = 10.0;
/// Values within this share of the range below the extreme are compared with it.
const NEIGHBOURS: f64 = 0.02;
/// Measurements at the extreme that prove anything, in all and in a row.
const FEWEST: usize = 10;
const FEWEST_IN_A_ROW: usize = 3;
/// A gyroscope that is cut off for more than this share of the walk has lost the
/// orientation.
const MOST_OF_RATES: f64 = 0.05;
/// Footfalls cut an accelerometer off at ±2 g for some milliseconds, which no filter minds;
/// one that is cut off for longer is in the wrong range.
const FOOTFALLS: f64 = 0.05;
const MOST_OF_ACCELERATIONS: f64 = 0.3;
/// An angle has no range to be cut off at; where it is, somebody clipped it. A peak that is
/// rounded to the last digit of a log stays for less than this share of the walk.
const LEAST_OF_ANGLES: f64 = 0.02;

/// `hold`: rows that show the same measurement.
pub(super) fn findings(rows: &Rows<'_>, hold: usize) -> Vec<Finding> {
    let walking = rows.walking();
    let mut found = Vec::new();
    for channel in rows.channels() {
        let values = &channel.values[walking.clone()];
        let share = cut_off_share(values, hold);
        let (least, most) = match channel.name.as_bytes() {
            [b'g', _] => (0.0, MOST_OF_RATES),
            [b'a', _] => (FOOTFALLS, MOST_OF_ACCELERATIONS),
            _ => (LEAST_OF_ANGLES, LEAST_OF_ANGLES),
        };
        if share <= least {
            continue;
        }
        let severity = if share > most {
            Severity::Useless
        } else {
            Severity::Worse
        };
        let reason = format!(
            "{} is cut off at the end of its range in {:.1} % of the walk",
            channel.name,
            100.0 * share
        );
        let cure = Some("a larger full-scale range of the sensor".into());
        found.push(rows.finding(FindingKind::Saturated, severity, reason, cure));
    }
    found
}

/// How many values are at an extreme, with so many of their neighbours at least: a peak that is
/// met again and again is none.
fn in_plateaus(values: &[f64], extreme: f64, fewest: usize) -> usize {
    values
        .chunk_by(|a, b| (*a == extreme) == (*b == extreme))
        .filter(|run| run.first() == Some(&extreme) && run.len() >= fewest)
        .map(<[f64]>::len)
        .sum()
}

/// Share of the values that are at an end of the range, zero where there is no such end.
fn cut_off_share(values: &[f64], hold: usize) -> f64 {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let range = high - low;
    if !(range > 0.0 && range.is_finite()) {
        return 0.0;
    }
    let at_ends: usize = [high, low]
        .into_iter()
        .map(|end| {
            let at_end = in_plateaus(values, end, FEWEST_IN_A_ROW * hold);
            let mut near: Vec<f64> = values
                .iter()
                .copied()
                .filter(|value| *value != end && (value - end).abs() < NEIGHBOURS * range)
                .collect();
            near.sort_by(f64::total_cmp);
            let count = near.len() as f64;
            near.dedup();
            let typical = count / near.len().max(1) as f64;
            let piled_up = at_end >= FEWEST * hold
                && at_end as f64 > PILED_UP * typical.max(hold as f64 / 2.0);
            if piled_up { at_end } else { 0 }
        })
        .sum();
    at_ends as f64 / values.len() as f64
}
