//! Forward selection: one effect at a time, on data that no fit has seen.

mod comparison;
mod describe;
mod search;
mod trial;

use mlr_filter::SettingError;
use search::Search;

use crate::{SensorError, SensorExplanation, SensorRecord};

/// How effects are selected.
#[derive(Debug, Clone, PartialEq)]
pub struct SelectionSettings {
    /// Probability of adding any effect where there is none, shared by all candidates.
    pub significance: f64,
    /// Complexity penalty: the share by which the error must fall for each parameter of an
    /// effect; twice that where the effect is rare.
    pub penalty_per_parameter: f64,
    /// Kinds that are not tried.
    pub without: Vec<String>,
    /// Whether effects of the motion rather than the sensor are tried.
    pub motion_effects: bool,
}

impl Default for SelectionSettings {
    fn default() -> Self {
        Self {
            significance: 0.05,
            penalty_per_parameter: 0.02,
            without: Vec::new(),
            motion_effects: false,
        }
    }
}

impl SelectionSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        SettingError::check("significance", self.significance, 1e-9..=1.0, "")?;
        let penalty = self.penalty_per_parameter;
        SettingError::check("penalty_per_parameter", penalty, 0.0..=1.0, "")
    }
}

/// Finds what the data sheet's model of a gyroscope lacks.
///
/// The record is divided in three ([`Stretches`](crate::Stretches)).
///
/// 1. **Fit.** Every candidate is fitted on the first stretch, together with the effects found
///    before. The model sees the signals of the sensor, never the reference angle, which serves
///    only to measure the error.
/// 2. **Selection.** The candidate is compared with the model without it on the second stretch,
///    in 15 blocks and in two ways: the errors as they are, and within each block less its mean,
///    which drift hardly touches. It is accepted when one of them falls by more than the
///    complexity penalty of its parameters, the error as it is does not rise where the one within
///    blocks decides, no parameter lies at the bound of what such sensors have, the 95 % intervals
///    on the fit stretch exclude that it is absent, and an exact sign-flip test over the blocks
///    has a p-value below `significance / candidates`. A drift is one random event rather than
///    fifteen, so that a smaller drift alone is evidence only while the error is above three times
///    the noise floor, or for effects that observe the drift, such as gravity, and have gained on
///    the fit stretch too. Of the most common among the accepted candidates
///    ([`Commonness`](crate::sensor_effects::Commonness)) the one that lowers the errors most for
///    each parameter is added, until none is left. Where no single effect that every sensor has is
///    accepted, pairs of them are tried. Last, each effect that not every sensor has is removed
///    and stays out unless it is accepted on top of all others.
/// 3. **Refit.** The parameters of the selected effects are fitted once more on the first two
///    stretches together.
/// 4. **Test.** The error of the result is measured on the third stretch, which decides nothing
///    about the model. So is that of the simpler corrections that it must be compared with
///    ([`SensorExplanation::baselines`]).
///
/// # Errors
/// [`SensorError::UnknownEffect`] for a kind in `without` that is not in the library,
/// [`SensorError::Setting`] for a number that makes no sense.
pub fn explain_sensor(
    record: &SensorRecord,
    settings: &SelectionSettings,
) -> Result<SensorExplanation, SensorError> {
    settings.check()?;
    for kind in &settings.without {
        crate::sensor_effects::find(kind).ok_or_else(|| SensorError::UnknownEffect {
            kind: kind.clone(),
            known: crate::sensor_effects::kinds(),
        })?;
    }
    let search = Search::new(record, settings);
    let selected = search.run();
    let refitted = selected.trial.model.refitted(search.record());
    Ok(describe::explanation(record, &search, &selected, &refitted))
}
