use std::{collections::BTreeMap, fs};

use mlr_ga::Identification;
use mlr_golden_tests::data;
use mlr_model::Morphology;
use serde::Deserialize;

/// What was done to the robot of a log.
#[derive(Deserialize)]
pub(crate) struct Truth {
    pub(crate) morphology: Morphology,
    pub(crate) motion_start_s: f64,
    pub(crate) effect: Option<String>,
    pub(crate) plant: serde_json::Value,
}

impl Truth {
    /// Of every log, by its name.
    pub(crate) fn all() -> BTreeMap<String, Self> {
        let text = fs::read_to_string(data("logs/stand-in/truth.json")).unwrap();
        serde_json::from_str(&text).unwrap()
    }

    pub(crate) fn damaged_legs(&self) -> Vec<usize> {
        self.morphology.damaged_legs()
    }

    /// Whether the answer names the damaged legs, and the truth is the answer or one of the few
    /// morphologies that the log cannot tell from it.
    pub(crate) fn is_answered_by(&self, answer: &Identification) -> bool {
        let listed = &answer.indistinguishable;
        let is_listed = self.is_exactly(answer) || listed.contains(&self.morphology);
        answer.damaged_legs == self.damaged_legs()
            && is_listed
            && listed.len() <= 12
            && !answer.implausible
    }

    /// Whether the answer is right down to the last link.
    pub(crate) fn is_exactly(&self, answer: &Identification) -> bool {
        answer.morphology == self.morphology
    }
}
