use mlr_filter::SettingError;
use serde::{Deserialize, Serialize};

/// How a gait is searched.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct RecoverSettings {
    /// No joint turns further from the posture of its leg than this: half of what a servo with 240°
    /// has to either side.
    pub most_turn_deg: f64,
    /// Steps of the quasi-static search over all orders together, about.
    pub screen_steps: usize,
    /// How many robots a gait is optimised on.
    pub robots: usize,
    /// How many robots it is judged on, those among them.
    pub judged_robots: usize,
    /// Generations of the optimisation, at most.
    pub generations: usize,
}

impl Default for RecoverSettings {
    fn default() -> Self {
        Self {
            most_turn_deg: 60.0,
            screen_steps: 800_000,
            robots: 6,
            judged_robots: 24,
            generations: 18,
        }
    }
}

impl RecoverSettings {
    /// Checks every number. No optimisation is valid: the best of the screened gaits is taken then.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        SettingError::check("most_turn_deg", self.most_turn_deg, 1.0..=180.0, "degrees")?;
        SettingError::check("screen_steps", self.screen_steps, 1..=1_000_000_000, "")?;
        let judged = self.judged_robots;
        SettingError::check("judged_robots", judged, 1..=1000, "")?;
        SettingError::check("robots", self.robots, 1..=judged, "")?;
        SettingError::check("generations", self.generations, 0..=1000, "")
    }
}
