//! A body that tips further than one that walks.

use super::{Finding, FindingKind, Severity, rows::Rows};
use crate::Correction;

/// A robot that walks damaged swings by 25° at most, and stands on slopes of less than 20°;
/// one that has turned further has tipped over, or is carried.
const LARGEST_TILT_DEG: f64 = 60.0;

pub(super) fn finding(rows: &Rows<'_>) -> Option<Finding> {
    let angles = rows.oriented_rad;
    [("roll", &angles.roll), ("pitch", &angles.pitch)]
        .into_iter()
        .find_map(|(name, values)| tipped_over(rows, name, values))
}

fn tipped_over(rows: &Rows<'_>, name: &str, values: &[f64]) -> Option<Finding> {
    let at_rest = match values.get(rows.standing.clone()) {
        Some(standing) if !standing.is_empty() => {
            standing.iter().sum::<f64>() / standing.len() as f64
        }
        _ => 0.0,
    };
    let tipped = |value: &f64| (value - at_rest).to_degrees().abs() > LARGEST_TILT_DEG;
    let first = values.iter().position(tipped)?;
    let last = values.iter().rposition(tipped)?;
    let largest_deg = values
        .iter()
        .map(|value| (value - at_rest).to_degrees().abs())
        .fold(0.0, f64::max);
    // Angles that no raw samples vouch for may as well be in degrees, from the first to the last.
    let in_doubt = rows.raw.is_none();
    let (begin_s, end_s) = rows.span_s();
    Some(Finding {
        kind: FindingKind::TippedOver,
        severity: Severity::Useless,
        from_s: if in_doubt {
            begin_s
        } else {
            rows.times_s[first]
        },
        to_s: if in_doubt { end_s } else { rows.times_s[last] },
        reason: format!(
            "{name} reaches {largest_deg:.0}° at {:.2} s: the robot has tipped over or is carried, a \
             walk stays within {LARGEST_TILT_DEG:.0}°",
            rows.times_s[first]
        ),
        cure: in_doubt.then(|| {
            let arguments = rows.arguments(&["roll", "pitch", "yaw"], Correction::Unit("deg"));
            format!("{arguments} if the angles are in degrees")
        }),
    })
}
