use mlr_filter::{Conditioned, FourierFilter, MotionStart, OrientationSeries, Window};

use super::{GaitPhase, IdentifySettings};
use crate::{
    AnswerError,
    detect::{Detection, detect_in},
    recording::repair_time_stamps,
};

/// A robot that walks calmly for this long before damage is flagged was healthy
/// when it started.
const CALM_WALK_S: f64 = 3.0;
/// A body that has just lost its balance finds its new gait within this time.
const UPSET_S: f64 = 1.0;

/// The part of a recording that a morphology has to explain: some seconds of the
/// walk, after the filter.
#[derive(Debug, Clone)]
pub struct MeasuredWalk {
    start: MotionStart,
    window: Window,
    phase: GaitPhase,
    conditioned: Conditioned,
    warnings: Vec<String>,
}

impl MeasuredWalk {
    /// Repairs the time stamps, finds the stretch to compare, and filters it.
    ///
    /// The stretch begins with the walk; where damage strikes in mid-walk, when
    /// it is flagged; and wherever the settings say so.
    ///
    /// # Errors
    /// [`AnswerError`] when the recording has no such stretch, or the settings
    /// make no sense.
    pub fn new(
        recording: OrientationSeries,
        settings: &IdentifySettings,
    ) -> Result<Self, AnswerError> {
        settings.check()?;
        let mut warnings = Vec::new();
        let recording = repair_time_stamps(recording, settings.max_dropped_share, &mut warnings)?;
        let start = match settings.motion_start_s {
            Some(start_s) => MotionStart {
                start_s,
                stood_before: true,
            },
            None => MotionStart::find(&recording, &settings.motion)?,
        };
        let start_of_window_s = match settings.from_s {
            Some(from_s) => from_s,
            None => struck_in_mid_walk(&recording, start, settings).unwrap_or(start.start_s),
        };
        let since_start_s = start_of_window_s - start.start_s;
        let phase = if !start.stood_before {
            warnings.push(
                "the log does not show the robot standing before it walks: the phase of the gait \
                 is fitted"
                    .into(),
            );
            GaitPhase::Unknown
        } else if since_start_s.abs() < f64::EPSILON {
            GaitPhase::Start
        } else {
            GaitPhase::Elapsed { since_start_s }
        };
        let window = Window {
            start_s: start_of_window_s,
            duration_s: settings.window_s,
        };
        let cut = window.cut(&recording, &settings.sampling)?;
        let conditioned = FourierFilter::new(settings.filter, settings.window_s)?.condition(&cut);
        Ok(Self {
            start,
            window,
            phase,
            conditioned,
            warnings,
        })
    }

    /// When the walk started.
    pub fn start(&self) -> MotionStart {
        self.start
    }

    /// The compared stretch.
    pub fn window(&self) -> Window {
        self.window
    }

    /// Where in the gait it begins.
    pub fn phase(&self) -> GaitPhase {
        self.phase
    }

    /// Roll, pitch and yaw after the filter.
    pub fn conditioned(&self) -> &Conditioned {
        &self.conditioned
    }

    /// What a person should know about the recording.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }
}

/// Where to compare when a healthy robot was damaged while it walked: from the
/// time the damage was flagged on, or as late as the recording allows.
fn struck_in_mid_walk(
    recording: &OrientationSeries,
    start: MotionStart,
    settings: &IdentifySettings,
) -> Option<f64> {
    // A recording that the detector cannot judge is left to the window's checks.
    let Detection {
        damage_s: Some(flagged_s),
        ..
    } = detect_in(recording, settings.detector).ok()?
    else {
        return None;
    };
    let struck_s = flagged_s - settings.detector.persistence_s;
    if struck_s - start.start_s < CALM_WALK_S {
        return None;
    }
    let latest_s = recording.times_s().last()? - settings.window_s;
    Some(flagged_s.min(latest_s).max(struck_s + UPSET_S))
}
