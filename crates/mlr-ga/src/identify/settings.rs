use mlr_filter::{DetectorSettings, FilterSettings, MotionSettings, SamplingLimits};
use mlr_model::{SimulationSettings, Variation};
use serde::{Deserialize, Serialize};

use crate::{
    AnswerError, LossHypothesis,
    belief::{DamagePrior, PlausibilitySettings},
    comparison::LikelihoodSettings,
    genetic::GeneticSettings,
    walks::usual_variations,
};

/// Everything about an identification that can be chosen. The defaults are the
/// paper's values where it gives one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct IdentifySettings {
    /// Length of the compared stretch.
    pub window_s: f64,
    /// Log time at which the walk started, where it is known from elsewhere; found
    /// in the recording otherwise.
    pub motion_start_s: Option<f64>,
    /// Log time at which the compared stretch begins, instead of the start of the
    /// walk or the time at which damage was flagged.
    pub from_s: Option<f64>,
    /// Largest share of samples that may be lost to bad time stamps.
    pub max_dropped_share: f64,
    /// What a lost link may have become.
    pub lost_links: LossHypothesis,
    /// The FFT filter.
    pub filter: FilterSettings,
    /// The search for the start of the walk.
    pub motion: MotionSettings,
    /// The damage detector, which tells damage in mid-walk.
    pub detector: DetectorSettings,
    /// What the recording must offer within the window.
    pub sampling: SamplingLimits,
    /// The genetic algorithm.
    pub genetic: GeneticSettings,
    /// What misfits say against a candidate.
    pub likelihood: LikelihoodSettings,
    /// What is thought of damage before the log is seen.
    pub prior: DamagePrior,
    /// How far off the right morphology usually is.
    pub plausibility: PlausibilitySettings,
    /// The nominal model, and how a robot may differ from it. The leading
    /// candidates are tried under all of them.
    pub variations: Vec<Variation>,
    /// Candidates that are tried under variations of the model, at most.
    pub leaders: usize,
    /// Share of the probability that the morphologies reported as indistinguishable
    /// hold together.
    pub credible_share: f64,
    /// How candidates are simulated. Duration and lost links follow from the
    /// settings above.
    pub simulation: SimulationSettings,
}

impl Default for IdentifySettings {
    fn default() -> Self {
        Self {
            window_s: 5.0,
            motion_start_s: None,
            from_s: None,
            max_dropped_share: 0.2,
            lost_links: LossHypothesis::default(),
            filter: FilterSettings::default(),
            motion: MotionSettings::default(),
            detector: DetectorSettings::default(),
            sampling: SamplingLimits::default(),
            genetic: GeneticSettings::default(),
            likelihood: LikelihoodSettings::default(),
            prior: DamagePrior::default(),
            plausibility: PlausibilitySettings::default(),
            variations: usual_variations(),
            leaders: 48,
            credible_share: 0.99,
            simulation: SimulationSettings::default(),
        }
    }
}

impl IdentifySettings {
    /// Checks what no other part checks on its own.
    pub(super) fn check(&self) -> Result<(), AnswerError> {
        let within = |field, value: f64, low: f64, high: f64, expected| {
            if (low..=high).contains(&value) {
                Ok(())
            } else {
                Err(AnswerError::Setting {
                    field,
                    value,
                    expected,
                })
            }
        };
        within("window_s", self.window_s, 0.5, 600.0, "0.5 to 600 s")?;
        within(
            "max_dropped_share",
            self.max_dropped_share,
            0.0,
            1.0,
            "a share from 0 to 1",
        )?;
        within(
            "credible_share",
            self.credible_share,
            0.0,
            1.0,
            "a share from 0 to 1",
        )?;
        within(
            "prior.leg_damaged",
            self.prior.leg_damaged,
            1e-9,
            0.999,
            "a probability above 0 and below 1",
        )?;
        within(
            "prior.remaining_link",
            self.prior.remaining_link,
            1e-6,
            1e6,
            "a positive factor",
        )?;
        within(
            "likelihood.floor_deg",
            self.likelihood.floor_deg,
            1e-6,
            45.0,
            "0.000001 to 45 degrees",
        )?;
        within(
            "likelihood.clock_deviation",
            self.likelihood.clock_deviation,
            1e-6,
            1.0,
            "0.000001 to 1",
        )?;
        for errors in self.likelihood.independent_errors {
            within(
                "likelihood.independent_errors",
                errors,
                0.01,
                1e6,
                "0.01 or more",
            )?;
        }
        within(
            "variations",
            self.variations.len() as f64,
            1.0,
            1e4,
            "at least the nominal model",
        )?;
        // Below this rate a simulated walk would not carry its own frequencies.
        within(
            "simulation.time_step_s",
            self.simulation.time_step_s,
            1e-5,
            1.0 / SamplingLimits::default().min_rate_hz,
            "0.00001 to 0.02 s",
        )?;
        self.genetic.check()?;
        Ok(())
    }
}
