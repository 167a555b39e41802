//! Where in a walk the comparison begins.

use mlr_filter::{DetectorSettings, MotionStart, OrientationSeries};

use super::IdentifySettings;
use crate::detect::detect_in;

/// A robot that walks calmly for this long before damage is flagged was healthy
/// when it started.
const CALM_WALK_S: f64 = 3.0;
/// After damage the walk is steady again within this time.
const UPSET_S: f64 = 1.0;

/// Where the compared stretch begins, other than at the start of the walk.
pub(super) struct Beginning {
    /// Log time.
    pub(super) time_s: f64,
    /// Log time until which a robot that was damaged in mid-walk walked as it began.
    pub(super) unchanged_until_s: Option<f64>,
}

impl Beginning {
    /// As the settings say, if they do.
    pub(super) fn told(settings: &IdentifySettings) -> Option<Self> {
        settings.from_s.map(|time_s| Self {
            time_s,
            unchanged_until_s: None,
        })
    }

    /// Where to begin when a healthy robot was damaged while it walked: when the damage was flagged or the
    /// swing changed, at the latest one window before the end.
    pub(super) fn after_damage_in_mid_walk(
        recording: &OrientationSeries,
        start: MotionStart,
        settings: &IdentifySettings,
    ) -> Option<Self> {
        // The window's own checks report a recording that is too slow for the detector.
        let flagged_s = match detect_in(recording, settings.detector).ok()?.damage_s {
            Some(flagged_s) => flagged_s,
            None if !settings.unflagged_damage => return None,
            None => {
                let threshold_deg = changed_swing_deg(recording, start, settings)?;
                let changed = DetectorSettings {
                    threshold_deg,
                    ..settings.detector
                };
                detect_in(recording, changed).ok()?.damage_s?
            }
        };
        let struck_s = flagged_s - settings.detector.persistence_s;
        if struck_s - start.start_s < CALM_WALK_S {
            return None;
        }
        let latest_s = recording.times_s().last()? - settings.window_s;
        Some(Self {
            time_s: flagged_s.min(latest_s).max(struck_s + UPSET_S),
            // A lost leg is missed where it should stand next; the window that shows it first ends then.
            unchanged_until_s: Some(
                struck_s - settings.detector.lull_s - settings.detector.window_s,
            ),
        })
    }
}

/// Threshold for damage that rocks the body by less than the detector's: several times the
/// fluctuation at the start of the walk.
fn changed_swing_deg(
    recording: &OrientationSeries,
    start: MotionStart,
    settings: &IdentifySettings,
) -> Option<f64> {
    const TIMES: f64 = 3.0;
    const LEAST_DEG: f64 = 1.5;
    let times_s = recording.times_s();
    // The first step differs from the others.
    let from = times_s.partition_point(|&t| t < start.start_s + UPSET_S);
    let to = times_s.partition_point(|&t| t < start.start_s + UPSET_S + CALM_WALK_S);
    let beginning = OrientationSeries::new(
        times_s[from..to].to_vec(),
        recording
            .angles_rad()
            .as_ref()
            .map(|_, angles| angles[from..to].to_vec()),
    )
    .ok()?;
    let swing_deg = detect_in(&beginning, settings.detector)
        .ok()?
        .max_fluctuation_deg;
    Some((TIMES * swing_deg).max(LEAST_DEG))
}
