//! Tracing a residual to effects that the model lacks.

mod calibrating;
mod chain;
mod contenders;
mod findings;
mod judging;
mod round;
mod state;
mod weighing;

use mlr_filter::SettingError;
use mlr_model::Morphology;
use serde::{Deserialize, Serialize};

use self::chain::Chain;
use super::{
    ComparisonSettings, StretchErrors, Trial, UsualRemainder, WalkError, WalkExplanation,
    WalkModel, WalkRecord, remainder::remainder,
};
use crate::Progress;

/// How effects are traced.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TracingSettings {
    /// How models are compared with the record.
    pub comparison: ComparisonSettings,
    /// What an effect must gain on either stretch before it is added, on average of both and
    /// half of it on each, besides the price of its parameters and places. The usual gain by chance, measured on logs of
    /// undisturbed robots (`docs/explain.md`), stays below it.
    pub least_gain: f64,
    /// Price of each parameter.
    pub price_per_parameter: f64,
    /// How many times the price an effect has where robots answer to anything: roll or pitch
    /// are off by more than 1.5° without it, or yaw by more than 2°.
    pub wild_price: f64,
    /// Effects that are added at most. What else was tried is reported as it was before the last
    /// of them.
    pub most_effects: usize,
    /// Candidates this close to the best in their gains on both stretches together are
    /// its rivals.
    pub rival_gain: f64,
    /// What a morphology with other damaged legs must gain on both stretches together before
    /// it takes the place of the one identified.
    pub switch_gain: f64,
    /// What the model leaves of robots that lack nothing.
    pub remainder: UsualRemainder,
}

impl Default for TracingSettings {
    fn default() -> Self {
        Self {
            comparison: ComparisonSettings::default(),
            least_gain: 6.0,
            price_per_parameter: 1.0,
            wild_price: 2.0,
            most_effects: 3,
            rival_gain: 6.0,
            switch_gain: 20.0,
            remainder: UsualRemainder::default(),
        }
    }
}

impl TracingSettings {
    /// Checks every number. Gains and prices of zero are valid, and so are no effects: then
    /// the robot's usual differences are fitted and the rest is described.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        let comparison = self.comparison.check();
        comparison.map_err(|error| error.under("comparison"))?;
        for (name, gain) in [
            ("least_gain", self.least_gain),
            ("price_per_parameter", self.price_per_parameter),
            ("wild_price", self.wild_price),
            ("rival_gain", self.rival_gain),
            ("switch_gain", self.switch_gain),
        ] {
            SettingError::check(name, gain, 0.0..=1e6, "")?;
        }
        SettingError::check("most_effects", self.most_effects, 0..=100, "")?;
        let remainder = self.remainder.check();
        remainder.map_err(|error| error.under("remainder"))
    }
}

/// A morphology that the robot may have.
#[derive(Debug, Clone, PartialEq)]
pub struct Suspect {
    /// Which links are left.
    pub morphology: Morphology,
    /// Logarithm of its probability before the record is compared with its walk.
    pub ln_prior: f64,
}

/// What is known of a robot's morphology beside how the record compares with its walk.
pub trait MorphologySearch: Sync {
    /// The morphologies that come into question when the model has these effects.
    fn with_effects(&self, model: &WalkModel) -> Vec<Suspect>;

    /// Logarithm of the probability of a morphology before the record is seen.
    fn ln_prior(&self, morphology: &Morphology) -> f64;
}

/// Finds what the model of a walk lacks.
///
/// Of the `suspects`, the first of which is the morphology as identified, the one is
/// taken that leaves least with the usual differences between robots fitted. Then every
/// effect of the library is fitted on the first stretch of the record, on top of those
/// found before, and measured on the second, which it never saw. Its gain is the fall of
/// n · ln(error²), summed over the axes, and of the price of the usual differences that
/// it makes unnecessary. The best one is added if its gains on both stretches together exceed
/// twice its price, and each half of it: the least gain that chance could give, something for each parameter, and
/// the logarithm of the number of places where it was tried. A leg that is taken for lost
/// is tried as a whole leg with something wrong in it as well. With the effect in place
/// the morphology is identified again. Effects are added until none is worth its price.
///
/// # Errors
/// [`WalkError`] when a setting makes no sense, or no suspect's walk can be simulated.
pub fn explain_walk(
    record: &WalkRecord,
    nominal: &WalkModel,
    suspects: &[Suspect],
    search: &dyn MorphologySearch,
    settings: &TracingSettings,
    progress: &dyn Progress,
) -> Result<WalkExplanation, WalkError> {
    settings.check()?;
    let mut nominal = nominal.clone();
    if record.is_dead_reckoned() {
        nominal.sensing.filter_time_s = f64::INFINITY;
    }
    let brief = record.brief();
    let tracing = Tracing {
        record,
        brief: &brief,
        nominal: &nominal,
        search,
        settings,
        progress,
    };
    let suspect = suspects.first().ok_or(WalkError::Diverged)?;
    let known = tracing.ranked(std::slice::from_ref(suspect), &[], None)?;
    let first = known.first().cloned().ok_or(WalkError::Diverged)?;
    let error_before = tracing.as_described(&suspect.morphology, first.lost_links())?;
    let error_calibrated = errors(&first.trial);
    let residual_before = tracing.decomposed(&first);
    let Chain {
        held: state,
        mut effects,
        mut candidates,
    } = tracing.chain(known, suspects)?;
    tracing.finish_effects(&state, &mut effects);
    if let Some(locked) = tracing.locked_links(&state)? {
        effects.push(locked);
    }
    let residual_after = tracing.decomposed(&state);
    let left = remainder(record, &state.model(), &residual_after, &settings.remainder);
    candidates.retain(|judged| !effects.iter().any(|effect| effect.kind == judged.kind()));
    let mut warnings = Vec::new();
    if record.standing().is_empty() {
        warnings
            .push("the log does not show the robot standing: offsets at rest are not known".into());
    }
    Ok(WalkExplanation {
        morphology_before: suspect.morphology.clone(),
        morphology: state.morphology.clone(),
        damaged_legs: state.morphology.damaged_legs(),
        effects,
        unexplained: left.unexplained,
        error_before,
        error_calibrated,
        error_after: errors(&state.trial),
        noise_floor_deg: left.floor_deg,
        usual_differences: state.usual_differences(),
        candidates: tracing.candidates(&candidates),
        residual: left.residual,
        residual_before,
        residual_after,
        stretch_s: record.fit().len() as f64 * WalkRecord::PERIOD_S,
        warnings,
    })
}

/// Keeps the first of each morphology.
fn dedup(suspects: &mut Vec<Suspect>) {
    let mut seen: Vec<Morphology> = Vec::new();
    suspects.retain(|suspect| {
        let new = !seen.contains(&suspect.morphology);
        if new {
            seen.push(suspect.morphology.clone());
        }
        new
    });
}

fn errors(trial: &Trial) -> StretchErrors {
    StretchErrors::new(trial.fit_deg2, trial.unseen_deg2)
}

struct Tracing<'a> {
    record: &'a WalkRecord,
    /// For first looks.
    brief: &'a WalkRecord,
    nominal: &'a WalkModel,
    search: &'a dyn MorphologySearch,
    settings: &'a TracingSettings,
    progress: &'a dyn Progress,
}
