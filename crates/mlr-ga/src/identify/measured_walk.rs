use mlr_filter::{Conditioned, FourierFilter, MotionStart, OrientationSeries, Window};

use super::IdentifySettings;
use crate::{AnswerError, recording::repair_time_stamps};

/// The part of a recording that a morphology has to explain: the first seconds
/// of the walk, after the filter.
#[derive(Debug, Clone)]
pub struct MeasuredWalk {
    start: MotionStart,
    conditioned: Conditioned,
    warnings: Vec<String>,
}

impl MeasuredWalk {
    /// Repairs the time stamps, finds the start of the walk and filters the
    /// window that begins there.
    ///
    /// # Errors
    /// [`AnswerError`] when the recording has no such window, or the settings
    /// make no sense.
    pub fn new(
        recording: OrientationSeries,
        settings: &IdentifySettings,
    ) -> Result<Self, AnswerError> {
        settings.check()?;
        let mut warnings = Vec::new();
        let recording = repair_time_stamps(recording, settings.max_dropped_share, &mut warnings)?;
        let start = MotionStart::find(&recording, &settings.motion)?;
        if !start.stood_before {
            warnings.push(
                "the log does not show the robot standing before it walks: the phase of the gait \
                 is unknown, the answer may be wrong"
                    .into(),
            );
        }
        let window = Window {
            start_s: start.start_s,
            duration_s: settings.window_s,
        };
        let cut = window.cut(&recording, &settings.sampling)?;
        let conditioned = FourierFilter::new(settings.filter, settings.window_s)?.condition(&cut);
        Ok(Self {
            start,
            conditioned,
            warnings,
        })
    }

    /// When the walk started.
    pub fn start(&self) -> MotionStart {
        self.start
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
