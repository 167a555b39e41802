use std::{collections::BTreeMap, fmt};

use mlr_model::Morphology;
use serde::Deserialize;

/// What else is wrong: what a page shows of `mlr.explanation/1`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Explanation {
    /// The log.
    pub log: String,
    /// The morphology with all effects in place.
    pub morphology: Morphology,
    /// Probability of each kind of effect, of `none` and `unknown`.
    pub effect_probability: BTreeMap<String, f64>,
    /// The most probable set of effects.
    pub effects: Vec<Effect>,
    /// The most probable hypotheses.
    #[serde(default)]
    pub alternatives: Vec<Hypothesis>,
    /// Whether something unknown is more probable than not.
    pub unexplained: bool,
    /// Errors of the robot as described.
    pub error_before: Errors,
    /// Errors of the robot as calibrated, without effects.
    pub error_calibrated: Errors,
    /// Errors with all effects.
    pub error_after: Errors,
    /// What sensor noise and the model's own shortcomings leave.
    pub noise_floor_deg: f64,
    /// Kinds that are not among the effects.
    #[serde(default)]
    pub candidates: Vec<Candidate>,
    /// What remains.
    pub residual: Remaining,
    /// What is left without effects.
    pub residual_before: Residuals,
    /// What is left with all effects.
    pub residual_after: Residuals,
    /// Where errors are measured.
    pub stretches_s: Stretches,
    /// For people.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// Seed of the search.
    pub seed: u64,
}

/// An effect that the model lacks.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Effect {
    /// Its kind.
    pub kind: String,
    /// Its parameters, with their units in their names.
    pub parameters: BTreeMap<String, Value>,
    /// The interval of each that holds it with 95 %.
    #[serde(default)]
    pub interval_95: BTreeMap<String, [f64; 2]>,
    /// Parameters that the log does not tell.
    #[serde(default)]
    pub undetermined: Vec<String>,
    /// Parameters at the end of their range.
    #[serde(default)]
    pub at_bound: Vec<String>,
    /// What it does to the walk.
    #[serde(default)]
    pub explains: String,
    /// Its probability.
    #[serde(default)]
    pub probability: Option<f64>,
    /// What could be in its place.
    #[serde(default)]
    pub rivals: Vec<Rival>,
}

/// What could be in the place of an effect.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Rival {
    /// Its kind.
    pub kind: String,
    /// Its parameters.
    pub parameters: BTreeMap<String, Value>,
}

/// What may be the case.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Hypothesis {
    /// The morphology.
    pub morphology: Morphology,
    /// Whether its lost links are locked.
    #[serde(default)]
    pub locked_links: bool,
    /// What else is wrong.
    pub effects: Vec<Rival>,
    /// Whether something is that no effect of the library makes.
    #[serde(default)]
    pub unknown: bool,
    /// Its probability.
    pub probability: f64,
}

/// A kind that is not among the effects.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Candidate {
    /// Its kind.
    pub kind: String,
    /// Error with it, on the stretch that decides nothing.
    #[serde(default)]
    pub validation_deg: Option<f64>,
    /// What became of it.
    pub verdict: String,
}

/// The value of a parameter.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// A quantity, or a number.
    Quantity(f64),
    /// Several numbers.
    Numbers(Vec<usize>),
}

/// Root mean square errors.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Errors {
    /// Over all axes, where parameters were fitted.
    pub fit_deg: f64,
    /// Over all axes, where they were not.
    pub validation_deg: f64,
    /// Roll, pitch, yaw, where parameters were fitted.
    pub fit_axes_deg: [f64; 3],
    /// Roll, pitch, yaw, where they were not.
    pub validation_axes_deg: [f64; 3],
}

/// What remains, in one axis.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Remaining {
    /// The axis.
    pub axis: String,
    /// Of the strongest oscillation.
    #[serde(default)]
    pub frequency_hz: Option<f64>,
    /// Of the same.
    #[serde(default)]
    pub amplitude_deg: Option<f64>,
    /// Whether it is in step with the gait.
    #[serde(default)]
    pub locked_to_gait: bool,
    /// How much there is.
    pub remaining_deg: f64,
    /// How much is usual.
    pub usual_deg: f64,
    /// In words.
    pub explains: String,
}

/// What is left of each axis.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Residuals {
    /// Of roll.
    pub roll: AxisResidual,
    /// Of pitch.
    pub pitch: AxisResidual,
    /// Of yaw.
    pub yaw: AxisResidual,
}

/// What is left of one axis.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct AxisResidual {
    /// Mean while the robot walks.
    pub walking_deg: f64,
    /// What repeats with the gait.
    pub harmonics: Vec<Harmonic>,
    /// Root mean square of the rest.
    pub irregular_deg: f64,
}

/// What is left at a multiple of the gait's frequency.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Harmonic {
    /// The frequency.
    pub frequency_hz: f64,
    /// The amplitude.
    pub amplitude_deg: f64,
}

/// Log times of stretches.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Stretches {
    /// Where parameters were fitted.
    pub fit: [f64; 2],
    /// Where they were not.
    pub validation: [f64; 2],
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Quantity(value) if value.fract() == 0.0 => write!(f, "{value}"),
            Self::Quantity(value) => write!(f, "{value:.3}"),
            Self::Numbers(numbers) => {
                let numbers: Vec<String> = numbers.iter().map(usize::to_string).collect();
                f.write_str(&numbers.join(" + "))
            }
        }
    }
}
