//! The settings of an explanation.

use mlr_filter::SettingError;
use serde::{Deserialize, Serialize};

use super::{Discrepancy, EffectPrior, Effort, NuisanceSettings};

/// How a walk is explained.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct EvidenceSettings {
    /// How robots of one make differ.
    pub nuisance: NuisanceSettings,
    /// What a walk of the right model gets wrong.
    pub discrepancy: Discrepancy,
    /// What the mean of its walks gets wrong.
    pub mean_discrepancy: Discrepancy,
    /// How probable effects are before the record is seen.
    pub prior: EffectPrior,
    /// How much is tried.
    pub effort: Effort,
}

impl Default for EvidenceSettings {
    fn default() -> Self {
        Self {
            nuisance: NuisanceSettings::default(),
            discrepancy: Discrepancy::default(),
            mean_discrepancy: Discrepancy::of_means(),
            prior: EffectPrior::default(),
            effort: Effort::default(),
        }
    }
}

impl EvidenceSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        self.nuisance
            .check()
            .map_err(|error| error.under("nuisance"))?;
        self.discrepancy
            .check()
            .map_err(|error| error.under("discrepancy"))?;
        self.mean_discrepancy
            .check()
            .map_err(|error| error.under("mean_discrepancy"))?;
        self.prior.check().map_err(|error| error.under("prior"))?;
        self.effort.check().map_err(|error| error.under("effort"))
    }
}
