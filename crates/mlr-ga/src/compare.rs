//! One morphology beside a recording.

use mlr_imu::Recording;
use mlr_model::{LostLinks, Morphology};
use serde::Serialize;

use crate::{AnswerError, ComparedSignals, IdentifySettings, MeasuredWalk, Model, PaperCost};

/// How a morphology's walk on the nominal model compares with a recording after Algorithm 2.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Comparison {
    /// The morphology.
    pub morphology: Morphology,
    /// What its lost links are taken to be: whatever gives the least F.
    pub lost_links: LostLinks,
    /// The paper's F.
    pub cost_rad: f64,
    /// F per sample and axis.
    pub mean_error_deg: f64,
    /// Log time at which the compared stretch begins.
    pub window_start_s: f64,
    /// What was compared.
    #[serde(skip)]
    pub signals: ComparedSignals,
}

/// Compares the walk of one `morphology` with a recording, by the paper's F.
///
/// # Errors
/// [`AnswerError`] when the recording has no stretch to compare, a setting makes no sense, or
/// the simulation diverged.
pub fn compare(
    recording: &Recording,
    model: Model<'_>,
    settings: &IdentifySettings,
    morphology: Morphology,
) -> Result<Comparison, AnswerError> {
    settings.check_on(model.robot)?;
    let measured = MeasuredWalk::new(recording, model.gait, settings)?;
    let cost = PaperCost::new(&measured, model.robot, model.gait, settings)?;
    let fit = cost
        .least(&morphology)
        .ok_or(AnswerError::AllDiverged { simulated: 1 })?;
    Ok(Comparison {
        morphology,
        lost_links: fit.lost_links,
        cost_rad: fit.cost_rad,
        mean_error_deg: fit.mean_error_deg(),
        window_start_s: measured.window().start_s,
        signals: ComparedSignals::new(&measured, fit.simulated, settings),
    })
}
