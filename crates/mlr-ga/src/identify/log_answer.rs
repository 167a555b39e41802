use mlr_imu::quality::LogQuality;
use serde::Serialize;

use super::{BestFit, ComparedSignals, IdentifySettings, MeasuredWalk};
use crate::PaperFit;

/// What one of the logs says of the best morphology.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct IdentifiedLog {
    /// The gait that the robot walked.
    pub gait: String,
    /// Log time at which the walk started, if the recording shows it.
    pub motion_start_s: Option<f64>,
    /// Log time at which the compared stretch begins.
    pub window_start_s: f64,
    /// Length of the compared stretch.
    pub window_s: f64,
    /// The paper's F of the best morphology on the nominal model.
    pub cost_rad: f64,
    /// F per sample and axis.
    pub mean_error_deg: f64,
    /// Probability, by this log alone, that something else than damage to legs decides how the
    /// robot walks. The paper's method does not ask.
    pub something_else_probability: Option<f64>,
    /// How the walk of the best morphology fits best.
    pub fit: BestFit,
    /// Quality of the recording.
    pub log_quality: LogQuality,
    /// Warnings for people.
    pub warnings: Vec<String>,
    /// The compared signals.
    #[serde(skip)]
    pub signals: ComparedSignals,
}

/// What a method decided of one log.
pub(super) struct LogVerdict {
    /// Probability of something else than damage, where the method asks for it.
    pub(super) something_else: Option<f64>,
    /// How the best morphology fits best.
    pub(super) fit: BestFit,
    /// F of the best morphology.
    pub(super) paper_fit: PaperFit,
}

impl LogVerdict {
    pub(super) fn into_answer(
        self,
        gait: &str,
        measured: &MeasuredWalk,
        settings: &IdentifySettings,
    ) -> IdentifiedLog {
        let start = measured.start();
        IdentifiedLog {
            gait: gait.into(),
            motion_start_s: start.stood_before.then_some(start.start_s),
            window_start_s: measured.window().start_s,
            window_s: measured.window().duration_s,
            cost_rad: self.paper_fit.cost_rad,
            mean_error_deg: self.paper_fit.mean_error_deg(),
            something_else_probability: self.something_else,
            fit: self.fit,
            log_quality: measured.quality().clone(),
            warnings: measured.warnings().to_vec(),
            signals: ComparedSignals::new(measured, self.paper_fit, settings),
        }
    }
}
