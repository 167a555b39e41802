use mlr_filter::{DetectorSettings, SettingError};

/// How a gait is searched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecoverSettings {
    /// Measures fluctuations of roll and pitch, with the threshold that they should stay below.
    pub detector: DetectorSettings,
    /// No joint turns further from the posture of its leg than this: half of what a servo with 240°
    /// has to either side.
    pub most_turn_deg: f64,
    /// How many robots a gait is optimised on.
    pub robots: usize,
}

impl Default for RecoverSettings {
    fn default() -> Self {
        Self {
            detector: DetectorSettings::default(),
            most_turn_deg: 60.0,
            robots: 6,
        }
    }
}

impl RecoverSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that makes no sense.
    pub fn check(&self) -> Result<(), SettingError> {
        self.detector
            .check()
            .map_err(|error| error.under("detector"))?;
        SettingError::check("most_turn_deg", self.most_turn_deg, 1.0..=180.0, "degrees")?;
        SettingError::check("robots", self.robots, 1..=1000, "")
    }
}
