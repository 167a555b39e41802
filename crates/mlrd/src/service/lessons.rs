//! When the service learns of its robot, and what it makes of that.

use std::{
    fs, io,
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, Instant, SystemTime},
};

use anyhow::Context;

use super::Service;
use crate::{
    background::{Job, LearnJob},
    event::Kind,
    learning::{
        Calibrations, LearnError, LearningSettings, Lesson, Outcome, ProcessorBudget,
        SavedCalibrations, Variety,
    },
    monitor::WalkStretch,
    output::Messages,
    robot_model::RobotModel,
    saved_state::{StateFile, replace},
};

/// Lessons so far, and what they wait for.
pub(super) struct Lessons {
    settings: LearningSettings,
    pub(super) known: Calibrations,
    stretches: Variety,
    budget: ProcessorBudget,
    begin: Instant,
    under_way: bool,
    /// The robot was flagged since the lesson under way began.
    doubted: bool,
    kept: Option<Kept>,
}

/// Where lessons are kept.
struct Kept {
    file: StateFile<SavedCalibrations>,
    /// The robot's description with its own numbers, as other programs read it, and the one before.
    robot: PathBuf,
    robot_before: PathBuf,
    description: String,
}

/// Names of the robot's descriptions in the state directory.
const ROBOT: &str = "robot.toml";
const ROBOT_BEFORE: &str = "robot.before.toml";

impl Lessons {
    /// Goes on where the state directory says that it ended.
    pub(super) fn start(
        settings: LearningSettings,
        model: &RobotModel,
        state_dir: Option<&Path>,
        messages: &Messages,
    ) -> anyhow::Result<Self> {
        let mut known = Calibrations::new(Arc::clone(&model.robot));
        let mut kept = None;
        if let Some(dir) = state_dir {
            let name = || dir.display().to_string();
            let file = StateFile::<SavedCalibrations>::new(dir).with_context(name)?;
            let (saved, notice) = file.load().with_context(name)?;
            let notice = match saved.calibrations(Arc::clone(&model.robot)) {
                Ok(calibrations) => {
                    known = calibrations;
                    notice
                }
                Err(mismatch) => Some(file.set_aside(&mismatch.to_string()).with_context(name)?),
            };
            if let Some(notice) = notice {
                messages.say(&notice);
            }
            kept = Some(Kept {
                file,
                robot: dir.join(ROBOT),
                robot_before: dir.join(ROBOT_BEFORE),
                description: model.description.clone(),
            });
        }
        Ok(Self {
            settings,
            known,
            stretches: Variety::new(settings.kept),
            budget: ProcessorBudget::new(settings.processor_share),
            begin: Instant::now(),
            under_way: false,
            doubted: false,
            kept,
        })
    }

    /// Takes a healthy stretch.
    pub(super) fn offer(&mut self, stretch: WalkStretch) {
        self.stretches.offer(stretch);
    }

    /// The robot was flagged: what was walked before may have been damaged as well.
    pub(super) fn doubt(&mut self) {
        self.stretches.clear();
        self.doubted = true;
    }
}

impl Service {
    pub(super) fn learn_when_due(&mut self) {
        let lessons = &mut self.lessons;
        if lessons.under_way
            || self.background.is_none()
            || !lessons.budget.allows(lessons.begin.elapsed())
        {
            return;
        }
        let Some((stretch, compared)) = lessons.stretches.take_pair() else {
            return;
        };
        lessons.under_way = true;
        lessons.doubted = false;
        let job = LearnJob {
            stretch,
            compared,
            sensing: self.state.sensing.unwrap_or_default(),
            known: Arc::clone(lessons.known.robot()),
            before: lessons.known.robot_before().map(Arc::clone),
        };
        self.ask(Job::Learn(Box::new(job)));
    }

    pub(super) fn learned(&mut self, outcome: Result<Outcome, LearnError>, busy: Duration) {
        let lessons = &mut self.lessons;
        lessons.under_way = false;
        lessons.budget.spent(lessons.begin.elapsed(), busy);
        match outcome {
            Ok(_) if lessons.doubted => self
                .messages
                .say("nothing is learned from a walk after which the robot was soon flagged"),
            Ok(Outcome::Learned(lesson)) => self.use_lesson(*lesson),
            Ok(Outcome::NoBetter { lost_nats }) => self.messages.say(&format!(
                "a healthy walk taught nothing: another one would be predicted worse by \
                 {lost_nats:.1} nats"
            )),
            Ok(Outcome::FellBack { lost_nats }) => {
                lessons.known.fall_back();
                self.save_calibrations(None);
                self.warn(&format!(
                    "calibration: the last one predicts a new walk worse than the one before it \
                     by {lost_nats:.1} nats; that one is used again"
                ));
            }
            Err(error) => self.warn(&format!("a walk is not learned from: {error}")),
        }
    }

    fn use_lesson(&mut self, lesson: Lesson) {
        let lessons = &mut self.lessons;
        lessons
            .known
            .learn(SystemTime::now(), &lesson, &lessons.settings);
        let wear = lessons.known.wear(&lessons.settings);
        let walks = lessons.known.known().map_or(0, |known| known.walks);
        self.save_calibrations(Some(&lesson));
        for one in &wear {
            self.messages.say(&format!(
                "wear: {} has drifted by {:.4} {} ({:.1} standard deviations)",
                one.parameter, one.change, one.unit, one.deviations
            ));
        }
        self.tell(Kind::Calibrated {
            result: Box::new(lesson.report),
            walks,
            gain_nats: lesson.gain_nats,
            wear,
        });
    }

    /// Calibrations that cannot be kept are no reason to end.
    fn save_calibrations(&self, lesson: Option<&Lesson>) {
        let Some(kept) = &self.lessons.kept else {
            return;
        };
        let saved = SavedCalibrations::of(&self.lessons.known);
        if let Err(error) = kept.file.save(&saved) {
            self.warn(&format!("calibration: {error}"));
        }
        let described = match lesson {
            Some(lesson) => kept.describe(lesson),
            None => kept.describe_as_before(),
        };
        if let Err(error) = described {
            self.warn(&format!("{}: {error:#}", kept.robot.display()));
        }
    }
}

impl Kept {
    fn describe(&self, lesson: &Lesson) -> anyhow::Result<()> {
        let text = lesson
            .report
            .description(&self.description, &lesson.robot)?;
        absent_is_fine(fs::rename(&self.robot, &self.robot_before))?;
        Ok(replace(&self.robot, text.as_bytes())?)
    }

    /// Of the description as its make has it there is no copy.
    fn describe_as_before(&self) -> anyhow::Result<()> {
        absent_is_fine(fs::remove_file(&self.robot))?;
        Ok(absent_is_fine(fs::rename(&self.robot_before, &self.robot))?)
    }
}

fn absent_is_fine(done: io::Result<()>) -> io::Result<()> {
    match done {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        done => done,
    }
}
