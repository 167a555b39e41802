//! One lesson: a healthy stretch of walk is checked, learned from, and what was learned is compared.

use mlr_filter::SettingError;
use mlr_ga::{
    CalibrateError, CalibrationReport, ExplainError, ExplainSettings, HealthyWalk,
    IdentifySettings, Model, WalkOrigin, calibrate, walk_record,
};
use mlr_model::{Gait, LostLinks, Morphology, Robot};
use mlr_residual::walk::{CalibratedWalk, EvidenceSettings, KnownRobot, Simulated, WalkModel};
use thiserror::Error;

use super::forgetting::aged;
use crate::monitor::WalkStretch;

/// What a lesson goes by.
#[derive(Debug, Clone, Copy)]
pub struct Round<'a> {
    /// The gait that the robot walks.
    pub gait: &'a Gait,
    /// The identification.
    pub identification: &'a IdentifySettings,
    /// The search for effects.
    pub explanation: &'a EvidenceSettings,
    /// Share of what is known that is forgotten first.
    pub forgetting: f64,
    /// What the report is labelled with.
    pub source: &'a str,
}

/// What became of a stretch.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// Something was learned.
    Learned(Box<Lesson>),
    /// What was learned predicts another walk worse than what was known before.
    NoBetter {
        /// Logarithm of the evidence lost.
        lost_nats: f64,
    },
    /// What was learned last predicts this walk worse than what was known before that.
    FellBack {
        /// Logarithm of the evidence lost.
        lost_nats: f64,
    },
}

/// A robot as known after one more stretch.
#[derive(Debug, Clone, PartialEq)]
pub struct Lesson {
    /// The robot.
    pub robot: Robot,
    /// How it came about.
    pub report: CalibrationReport,
    /// Logarithm of the evidence that another walk gains.
    pub gain_nats: f64,
}

/// Why a stretch teaches nothing.
#[derive(Debug, Error)]
pub enum LearnError {
    /// It may not be healthy, or does not show what it takes.
    #[error(transparent)]
    Calibrate(#[from] CalibrateError),
    /// The walk that calibrations are compared on cannot be compared with a model's.
    #[error(transparent)]
    Compared(#[from] ExplainError),
    /// A setting makes no sense.
    #[error(transparent)]
    Setting(#[from] SettingError),
}

/// A loss of evidence below this is none.
const WORSE_NATS: f64 = 1.0;

/// Whether a calibration in use is taken back that has so much less evidence than the one before it.
/// What cannot be compared is no reason.
fn predicts_worse(lost_nats: f64) -> bool {
    lost_nats > WORSE_NATS
}

/// Whether a new calibration is used that has so much more evidence than the one in use. What cannot be
/// compared is no better.
fn predicts_better(gain_nats: f64) -> bool {
    gain_nats > 0.0
}

impl Round<'_> {
    /// Learns from `stretch` on top of what is `known`. Damage and effects are looked for in it first;
    /// then what is known must predict it as well as what was known `before`, where there is such a
    /// robot, and what is learned must predict `compared`, which is not learned from, better than what
    /// is known.
    ///
    /// # Errors
    /// [`LearnError`] where the stretch is not surely healthy, or cannot be compared.
    pub fn learn(
        &self,
        stretch: &WalkStretch,
        compared: &WalkStretch,
        known: &Robot,
        before: Option<&Robot>,
    ) -> Result<Outcome, LearnError> {
        let identification = self.identification_of(stretch);
        let settings = ExplainSettings {
            identify: &identification,
            explanation: self.explanation,
        };
        let walk = HealthyWalk {
            recording: &stretch.recording,
            gait: self.gait,
        };
        let older = aged(known, &self.explanation.nuisance, self.forgetting)?;
        let learned = calibrate(&[walk], &older, settings, true, &());
        let learned = learned.map_err(|(_, error)| error)?;
        let lost_nats = before
            .map(|before| -> Result<f64, LearnError> {
                Ok(self.ln_evidence(stretch, before)? - self.ln_evidence(stretch, known)?)
            })
            .transpose()?;
        if let Some(lost_nats) = lost_nats.filter(|lost_nats| predicts_worse(*lost_nats)) {
            return Ok(Outcome::FellBack { lost_nats });
        }
        let gain_nats =
            self.ln_evidence(compared, &learned.robot)? - self.ln_evidence(compared, known)?;
        if !predicts_better(gain_nats) {
            return Ok(Outcome::NoBetter {
                lost_nats: -gain_nats,
            });
        }
        let origin = WalkOrigin {
            log: self.source.to_owned(),
            sha256: String::new(),
            gait: self.gait.name.clone(),
        };
        let make = &self.explanation.nuisance;
        Ok(Outcome::Learned(Box::new(Lesson {
            report: CalibrationReport::new(known, &learned, make, vec![origin]),
            robot: learned.robot,
            gain_nats,
        })))
    }

    /// Logarithm of the evidence of a healthy walk of this robot: how well it is predicted, for how
    /// surely that is.
    fn ln_evidence(&self, stretch: &WalkStretch, robot: &Robot) -> Result<f64, LearnError> {
        let identification = self.identification_of(stretch);
        let model = Model::new(robot, self.gait);
        let record = walk_record(
            &stretch.recording,
            model,
            &identification,
            &self.explanation.nuisance,
        )?;
        let simulation = identification.simulation.clone();
        let model = WalkModel::of_make(
            robot.clone(),
            self.gait.clone(),
            simulation,
            &self.explanation.nuisance,
        );
        let known = KnownRobot {
            morphology: &Morphology::healthy(&robot.layout()),
            lost_links: LostLinks::Absent,
            effects: Vec::new(),
        };
        let once = Simulated::Once;
        let walk = CalibratedWalk::new(&record, &model, &known, once, self.explanation)?;
        Ok(walk.map_or(f64::NEG_INFINITY, |walk| walk.ln_evidence))
    }

    fn identification_of(&self, stretch: &WalkStretch) -> IdentifySettings {
        IdentifySettings {
            walk_start: stretch.walk_start,
            from_s: Some(stretch.from_s),
            ..self.identification.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_in_use_changes_only_for_more_evidence() {
        // A robot that does not walk at all has none.
        let none = f64::NEG_INFINITY;
        for (of_new, of_known, used) in [
            (10.0, 9.9, true),
            (9.9, 10.0, false),
            (10.0, 10.0, false),
            (10.0, none, true),
            (none, 10.0, false),
            (none, none, false),
        ] {
            assert_eq!(
                predicts_better(of_new - of_known),
                used,
                "{of_new} {of_known}"
            );
        }
        for (of_before, of_known, taken_back) in [
            (10.0, 8.0, true),
            (10.0, 9.5, false),
            (8.0, 10.0, false),
            (10.0, none, true),
            (none, none, false),
        ] {
            assert_eq!(
                predicts_worse(of_before - of_known),
                taken_back,
                "{of_before} {of_known}"
            );
        }
    }
}
