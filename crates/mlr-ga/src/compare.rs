//! One morphology beside a recording.

use mlr_imu::Recording;
use mlr_model::{LostLinks, Morphology};
use serde::Serialize;

use crate::{
    AnswerError, BestFit, ComparedSignals, IdentifySettings, MeasuredWalk, Model, PaperCost,
};

/// How a morphology's walk on a model compares with a recording after Algorithm 2.
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
    Comparison::new(&measured, &cost, settings, morphology)
}

/// Compares the walk of one `morphology` on the model that an answer found likeliest: its variation,
/// clock and delay, and what became of lost links.
///
/// # Errors
/// Those of [`compare`].
pub fn compare_fit(
    recording: &Recording,
    model: Model<'_>,
    settings: &IdentifySettings,
    morphology: Morphology,
    fit: &BestFit,
) -> Result<Comparison, AnswerError> {
    settings.check_on(model.robot)?;
    let measured = MeasuredWalk::new(recording, model.gait, settings)?;
    let cost = PaperCost::of_fit(&measured, model.robot, model.gait, settings, fit)?;
    Comparison::new(&measured, &cost, settings, morphology)
}

impl Comparison {
    fn new(
        measured: &MeasuredWalk,
        cost: &PaperCost,
        settings: &IdentifySettings,
        morphology: Morphology,
    ) -> Result<Self, AnswerError> {
        let fit = cost
            .least(&morphology)
            .ok_or(AnswerError::AllDiverged { simulated: 1 })?;
        Ok(Self {
            morphology,
            lost_links: fit.lost_links,
            cost_rad: fit.cost_rad,
            mean_error_deg: fit.mean_error_deg(),
            window_start_s: measured.window().start_s,
            signals: ComparedSignals::new(measured, fit, settings),
        })
    }
}

#[cfg(test)]
mod tests {
    use mlr_model::{Outcome, SimulationSettings, Simulator, Variation};

    use super::*;
    use crate::comparison::Alignment;

    #[test]
    fn the_model_that_fits_walks_as_the_robot_did() {
        let model = Model::jethexa();
        let fit = BestFit {
            gait_start_s: None,
            lost_links: LostLinks::Locked,
            alignment: Alignment {
                clock: 0.02,
                delay_s: 0.04,
            },
            variation: Variation {
                friction: 0.6,
                stiffness: 0.8,
                ..Variation::default()
            },
            error_deg: [0.0; 3],
            motion_deg: [0.0; 3],
        };
        let settings = SimulationSettings {
            stand_s: 1.0,
            duration_s: 3.0,
            lost_links: fit.lost_links,
            ..Default::default()
        };
        let (robot, settings) = fit.variation.apply(model.robot, &settings).unwrap();
        let morphology = Morphology::healthy(&robot.layout()).without_leg(1);
        let simulator = Simulator::new(robot, model.gait, settings).unwrap();
        let Outcome::Walked(walk) = simulator.simulate(&morphology) else {
            panic!("diverged");
        };
        let recording = fit.alignment.of_walk(&walk.orientation, 0.0).into_owned();
        let settings = IdentifySettings {
            window_s: 2.0,
            // Where the robot was told to walk, which it does later.
            walk_start: crate::WalkStart::CommandedAtS(0.0),
            ..IdentifySettings::default()
        };
        let error_deg = |comparison: Result<Comparison, AnswerError>| {
            let comparison = comparison.unwrap();
            assert_eq!(
                comparison.signals.measured_unfiltered.angles_rad().yaw[0],
                0.0
            );
            comparison.mean_error_deg
        };
        let recording = recording.into();
        let nominal = compare(&recording, model, &settings, morphology.clone());
        let fitted = compare_fit(&recording, model, &settings, morphology, &fit);
        let (nominal_deg, fitted_deg) = (error_deg(nominal), error_deg(fitted));
        assert!(fitted_deg < 0.05, "{fitted_deg}");
        assert!(
            nominal_deg > 5.0 * fitted_deg,
            "{nominal_deg}, {fitted_deg}"
        );
    }
}
