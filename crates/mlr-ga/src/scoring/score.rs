use mlr_model::Morphology;
use serde::{Deserialize, Serialize};

use super::Truth;
use crate::Identification;

/// One answer against the truth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LogScore {
    /// Name of the log.
    pub log: String,
    /// Numbers of the legs that were damaged.
    pub true_damaged_legs: Vec<usize>,
    /// Numbers of the legs that were named.
    pub damaged_legs: Vec<usize>,
    /// What was left of the robot.
    pub true_morphology: Morphology,
    /// What was answered.
    pub morphology: Morphology,
    /// Whether exactly the damaged legs were named.
    pub legs_right: bool,
    /// Whether every link was right.
    pub links_right: bool,
    /// Whether the truth is the answer or among the indistinguishable.
    pub covered: bool,
    /// How many morphologies could not be told from the answer, itself included.
    pub listed: usize,
    /// Probability given to each leg's being damaged.
    pub leg_damage_probability: Vec<f64>,
    /// Mean square of the error of these probabilities.
    pub brier: f64,
    /// Probability given to the set of legs that was named.
    pub confidence: f64,
    /// Probability given to something else than damage to legs, where the method asks for it.
    pub something_else_probability: Option<f64>,
    /// Root mean square of what the answer leaves of roll, pitch and yaw.
    pub error_deg: [f64; 3],
    /// Mean error of the nominal model, per sample and axis.
    pub mean_error_deg: f64,
    /// Root mean square of roll, pitch and yaw.
    pub motion_deg: [f64; 3],
    /// Time that the answer took.
    pub elapsed_s: f64,
}

impl LogScore {
    /// Scores an answer that took `elapsed_s`.
    pub fn new(truth: &Truth, answer: &Identification, elapsed_s: f64) -> Self {
        let true_morphology = &truth.morphology;
        let damaged = true_morphology.damaged_legs();
        let is_damaged = |leg: usize| damaged.contains(&(leg + 1));
        let brier = mean(answer.leg_damage_probability.iter().enumerate().map(
            |(leg, probability)| (probability - f64::from(u8::from(is_damaged(leg)))).powi(2),
        ));
        Self {
            log: truth.name.clone(),
            legs_right: answer.damaged_legs == damaged,
            links_right: answer.morphology == *true_morphology,
            covered: answer.morphology == *true_morphology
                || answer.indistinguishable.contains(true_morphology),
            listed: answer.indistinguishable.len() + 1,
            leg_damage_probability: answer.leg_damage_probability.clone(),
            brier,
            confidence: answer.legs_probability,
            something_else_probability: answer.something_else_probability,
            error_deg: answer.fit.error_deg,
            mean_error_deg: answer.mean_error_deg,
            motion_deg: answer.fit.motion_deg,
            true_damaged_legs: damaged,
            damaged_legs: answer.damaged_legs.clone(),
            true_morphology: true_morphology.clone(),
            morphology: answer.morphology.clone(),
            elapsed_s,
        }
    }

    /// The damage in words: the truth and the answer.
    pub fn in_words(&self) -> [String; 2] {
        [&self.true_morphology, &self.morphology].map(Morphology::describe)
    }
}

pub(super) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0, 0.0), |(count, sum), value| (count + 1, sum + value));
    sum / f64::from(count.max(1))
}
