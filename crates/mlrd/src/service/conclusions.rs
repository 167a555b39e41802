//! What the monitor wants done, and what comes of it: identifications, explanations and recovery gaits.

use std::{sync::Arc, time::SystemTime};

use mlr_ga::{diagnosis_of_explanation, diagnosis_of_identification};
use mlr_recover::Diagnosis;

use super::Service;
use crate::{
    background::Job,
    event::Kind,
    explainer::Explained,
    monitor::Action,
    recovery_offer::{NoOffer, RecoverJob, RecoveryOffer},
    saved_state::KnownMorphology,
    sensor_correction,
    worker::{Answer, Worker},
};

impl Service {
    pub(super) fn act(&mut self, action: Action) {
        let sensing = self.state.sensing.unwrap_or_default();
        let robot = || Arc::clone(self.lessons.known.robot());
        match action {
            Action::Report(kind) => {
                if let Kind::DamageDetected { .. } = kind {
                    self.lessons.doubt();
                }
                self.tell(kind);
            }
            Action::Identify(request) => {
                let number = request.number;
                if let Err(error) = Worker::identify(&self.worker, request, sensing, robot()) {
                    let report = Err(error.into());
                    self.answered(Answer { number, report });
                }
            }
            Action::Explain(request) => {
                if self.explains {
                    let robot = robot();
                    self.ask(Job::Explain(Box::new(request), sensing, robot));
                }
            }
            Action::Learn(stretch) => self.lessons.offer(*stretch),
        }
    }

    /// Asks for what is done when nothing else is to be done.
    pub(super) fn ask(&mut self, job: Job) {
        if let Some(background) = &self.background
            && !background.ask(job)
        {
            self.background = None;
            self.warn("explanations and learning end: the thread that does it has died");
        }
    }

    pub(super) fn answered(&mut self, answer: Answer) {
        let Answer { number, report } = answer;
        match report {
            Ok(report) if self.monitor.is_sound(number) => {
                // Of a walk that no morphology explains nothing is worth keeping.
                if !report.identification.implausible {
                    let known = KnownMorphology::new(SystemTime::now(), &report.identification);
                    self.state.last_known = Some(known);
                    self.save();
                }
                let found = &report.identification;
                let is_damage = !found.implausible && !found.damaged_legs.is_empty();
                let diagnosis = is_damage.then(|| diagnosis_of_identification(found));
                let result = Box::new(report);
                self.tell(Kind::Identified { result });
                let next = self.monitor.identified(number);
                // What else is wrong may forbid what lost legs allow.
                match next {
                    Some(Action::Explain(_)) if self.explains => self.to_recover = diagnosis,
                    _ => self.recover_from(diagnosis),
                }
                if let Some(next) = next {
                    self.act(next);
                }
            }
            report => {
                self.monitor.unidentified(number);
                let reason = match report {
                    Ok(_) => "the sensor had a fault during this walk".to_string(),
                    Err(error) => error.to_string(),
                };
                self.tell(Kind::Unidentified { reason });
            }
        }
    }

    pub(super) fn explained(&mut self, explained: Explained) {
        let Explained {
            number,
            report,
            corrected,
        } = explained;
        let identified = self.to_recover.take();
        let report = match report {
            _ if !self.monitor.is_sound(number) => {
                return self.warn("explanation: the sensor had a fault during this walk");
            }
            Ok(report) => report,
            Err(error) => {
                self.warn(&format!("explanation: {error}"));
                return self.recover_from(identified);
            }
        };
        let known = diagnosis_of_explanation(self.lessons.known.robot(), &report.explanation);
        let impaired = !known.most_probable().is_sound();
        self.recover_from(impaired.then_some(known));
        let better = sensor_correction::known_better(corrected, &report.explanation);
        let result = Box::new(report);
        self.tell(Kind::Explained { result });
        let Some(sensing) = better else {
            return;
        };
        self.state.sensing = Some(sensing);
        self.save();
        self.monitor.correct_for(sensing);
        self.messages.say(&format!(
            "sensor corrected from now on: {}",
            sensor_correction::in_words(&sensing)
        ));
        self.tell(Kind::SensorCorrected { sensing });
    }

    /// Asks for a gait that walks again, where one is to be offered.
    fn recover_from(&mut self, diagnosis: Option<Diagnosis>) {
        if let Some(diagnosis) = diagnosis.filter(|_| self.recovery_dir.is_some()) {
            let robot = Arc::clone(self.lessons.known.robot());
            self.ask(Job::Recover(Box::new(RecoverJob { diagnosis, robot })));
        }
    }

    pub(super) fn recovered(&mut self, found: Result<Box<RecoveryOffer>, NoOffer>) {
        let offer = match found {
            Ok(offer) => offer,
            Err(error) => return self.warn(&format!("recovery gait: {error}")),
        };
        let Some(dir) = &self.recovery_dir else {
            return;
        };
        match offer.write(dir) {
            Ok([gait, joints]) => {
                let result = Box::new(offer.report);
                self.tell(Kind::RecoveryGait {
                    gait,
                    joints,
                    result,
                });
            }
            Err(error) => self.warn(&format!("recovery gait: {error}")),
        }
    }
}
