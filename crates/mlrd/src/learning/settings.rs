//! What can be chosen about learning.

use mlr_filter::SettingError;
use serde::{Deserialize, Serialize};

/// How the robot is learned from its healthy walks, the section `[learning]` of the settings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct LearningSettings {
    /// Length of a stretch of walk that is learned from.
    pub walk_s: f64,
    /// How long the robot must walk on unflagged after a stretch before it is learned from.
    pub settled_s: f64,
    /// Time between the ends of two stretches of one walk, apart from its beginning.
    pub every_s: f64,
    /// Stretches that are kept to choose from.
    pub kept: usize,
    /// Share of one processor that learning takes on average.
    pub processor_share: f64,
    /// Share of the variance among robots of the make that what is known of this one gains with
    /// each stretch learned: the calibration is that of the last few stretches, about as many as
    /// this goes into one.
    pub forgetting: f64,
    /// Stretches after which the calibration becomes the reference for wear.
    pub reference_walks: u32,
    /// Drift that is told as wear, in standard deviations.
    pub wear_deviations: f64,
}

impl Default for LearningSettings {
    fn default() -> Self {
        Self {
            walk_s: 12.0,
            settled_s: 30.0,
            every_s: 60.0,
            kept: 4,
            processor_share: 0.04,
            forgetting: 0.1,
            reference_walks: 4,
            wear_deviations: 3.0,
        }
    }
}

impl LearningSettings {
    /// Checks every number; `window_s` is what an identification needs.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self, window_s: f64) -> Result<(), SettingError> {
        let check = SettingError::check::<f64>;
        check("walk_s", self.walk_s, 3.5..=12.0, "s")?;
        let least_s = window_s + 0.5;
        if self.walk_s < least_s {
            let expected =
                format!("at least identification.window_s and half a second, {least_s} s");
            return Err(SettingError::new("walk_s", self.walk_s, expected));
        }
        check("settled_s", self.settled_s, 1.0..=86_400.0, "s")?;
        check("every_s", self.every_s, 1.0..=86_400.0, "s")?;
        SettingError::check("kept", self.kept, 2..=64, "stretches")?;
        check("processor_share", self.processor_share, 1e-4..=1.0, "")?;
        check("forgetting", self.forgetting, 1e-6..=1.0, "")?;
        SettingError::check(
            "reference_walks",
            self.reference_walks,
            1..=1000,
            "stretches",
        )?;
        check("wear_deviations", self.wear_deviations, 1.0..=100.0, "")
    }
}
