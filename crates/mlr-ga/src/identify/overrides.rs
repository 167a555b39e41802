use mlr_filter::SettingError;

use super::{IdentifySettings, Search, WalkStart};
use crate::{LARGEST_SEED, LossHypothesis};

/// Settings that come with a call, in place of those of a configuration.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct IdentifyOverrides {
    /// How the morphologies are searched.
    pub search: Option<Search>,
    /// Seed of the genetic algorithm.
    pub seed: Option<u64>,
    /// How often the genetic algorithm runs.
    pub repeats: Option<usize>,
    /// Log time at which the robot was commanded to walk.
    pub start_s: Option<f64>,
    /// Length of the compared stretch.
    pub window_s: Option<f64>,
    /// Log time at which the compared stretch begins.
    pub from_s: Option<f64>,
    /// What a lost link may have become.
    pub lost_links: Option<LossHypothesis>,
    /// Friction between feet and ground.
    pub friction: Option<f64>,
}

impl IdentifyOverrides {
    /// The settings with these in their place, checked.
    ///
    /// # Errors
    /// [`SettingError`] naming the field of this, or the setting.
    pub fn over(self, mut settings: IdentifySettings) -> Result<IdentifySettings, SettingError> {
        if let Some(seed) = self.seed {
            SettingError::check("seed", seed, 0..=LARGEST_SEED, "")?;
            settings.seed = seed;
        }
        settings.search = self.search.or(settings.search);
        settings.genetic.repeats = self.repeats.unwrap_or(settings.genetic.repeats);
        if let Some(start_s) = self.start_s {
            settings.walk_start = WalkStart::CommandedAtS(start_s);
        }
        settings.window_s = self.window_s.unwrap_or(settings.window_s);
        settings.from_s = self.from_s.or(settings.from_s);
        settings.lost_links = self.lost_links.unwrap_or(settings.lost_links);
        let contact = &mut settings.simulation.contact;
        contact.friction = self.friction.unwrap_or(contact.friction);
        let checked = settings.check().map_err(|error| {
            error.as_option(&[
                ("walk_start.commanded_at_s", "start_s"),
                ("genetic.repeats", "repeats"),
                ("simulation.contact.friction", "friction"),
            ])
        });
        checked.map(|()| settings)
    }
}
