//! A servo on a bench: what its data sheet lacks.

mod evidence;
mod hypothesis;
mod model;
mod recording;
mod report;
mod search;

pub use model::ServoModel;
pub use recording::{ServoError, ServoRecording};
pub use report::{
    RecordingError, ServoCandidate, ServoExplanation, ServoSignals, TracedServoEffect,
};
pub use search::explain_servo;

use mlr_filter::SettingError;
use mlr_model::bench::Bench;

use crate::servo_effects::{self, ServoEffect};

/// How a servo is explained.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ServoSettings {
    /// Kinds that are fitted, all of them and no others; none: whatever evidence finds.
    pub effects: Option<Vec<String>>,
    /// Kinds that are not tried.
    pub without: Vec<String>,
}

impl ServoSettings {
    /// Checks that every kind is known.
    ///
    /// # Errors
    /// [`SettingError`] naming the first that is not.
    pub fn check(&self) -> Result<(), SettingError> {
        let named = self.effects.iter().flatten().map(|kind| ("effects", kind));
        let without = self.without.iter().map(|kind| ("without", kind));
        for (name, kind) in named.chain(without) {
            if servo_effects::find(kind).is_none() {
                let expected = format!("one of {}", servo_effects::kinds());
                return Err(SettingError::new(name, kind, expected));
            }
        }
        Ok(())
    }

    /// Effects that can be tried on this bench with these recordings.
    fn candidates(
        &self,
        bench: &Bench,
        recordings: &[ServoRecording],
    ) -> Vec<&'static dyn ServoEffect> {
        let wanted = |effect: &&'static dyn ServoEffect| {
            let kind = effect.kind();
            let chosen = self.effects.as_ref();
            chosen.is_none_or(|kinds| kinds.iter().any(|one| one == kind))
                && !self.without.iter().any(|one| one == kind)
                && effect.shows_in(bench, recordings)
        };
        servo_effects::LIBRARY
            .iter()
            .copied()
            .filter(wanted)
            .collect()
    }
}
