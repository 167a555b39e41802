//! What is done when nothing else is to be done: explanations, then recovery gaits, and then learning.

use std::{
    collections::VecDeque,
    sync::{
        Arc,
        mpsc::{self, Receiver, Sender},
    },
    thread,
    time::{Duration, Instant},
};

use mlr_model::Robot;
use mlr_recover::RecoverSettings;
use mlr_residual::walk::{EvidenceSettings, Sensing};

use crate::{
    explainer::{Explained, explain_request},
    learning::{LearnError, Outcome, Round},
    monitor::{Request, WalkStretch},
    output::Messages,
    priority,
    recovery_offer::{NoOffer, RecoverJob, RecoveryOffer},
    robot_model::RobotModel,
};

/// Does one thing after the other, on threads of the lowest priority.
pub struct Background {
    jobs: Sender<Job>,
}

/// Something to be done. The sensor's faults are taken out of recordings first.
#[derive(Debug)]
pub enum Job {
    /// Explain a walk of a robot known like this. Those that are asked for later replace those that
    /// wait.
    Explain(Box<Request>, Sensing, Arc<Robot>),
    /// Find a gait that walks again. Explanations come first; one that is asked for later replaces one
    /// that waits.
    Recover(Box<RecoverJob>),
    /// Learn from a walk, after everything else.
    Learn(Box<LearnJob>),
}

/// A walk to learn from.
#[derive(Debug)]
pub struct LearnJob {
    /// The walk.
    pub stretch: Arc<WalkStretch>,
    /// Another one, to compare calibrations on.
    pub compared: Arc<WalkStretch>,
    /// What the sensor adds.
    pub sensing: Sensing,
    /// The robot as it is known.
    pub known: Arc<Robot>,
    /// As it was known before that, where it was.
    pub before: Option<Arc<Robot>>,
}

/// What came of a job.
#[derive(Debug)]
pub enum Done {
    /// An explanation.
    Explained(Box<Explained>),
    /// A gait that walks again, or why there is none.
    Recovered(Result<Box<RecoveryOffer>, NoOffer>),
    /// A lesson, or why there is none, and how long it took.
    Learned(Result<Outcome, LearnError>, Duration),
}

/// What jobs are done with.
struct Bench {
    /// For what somebody waits for: explanations and recovery gaits.
    awaited: rayon::ThreadPool,
    /// One thread for what is learned, which has a share of one processor (`processor_share`).
    learning: rayon::ThreadPool,
    known: Arc<RobotModel>,
    explanation: EvidenceSettings,
    recovery: RecoverSettings,
    forgetting: f64,
}

impl Background {
    /// One that explains and looks for gaits on so many threads, and answers to `done`; a lesson
    /// forgets such a share of what was known before.
    ///
    /// # Errors
    /// When no thread is to be had.
    pub fn new(
        threads: usize,
        known: Arc<RobotModel>,
        explanation: EvidenceSettings,
        recovery: RecoverSettings,
        forgetting: f64,
        messages: &Messages,
        done: Sender<Done>,
    ) -> anyhow::Result<Self> {
        let bench = Bench {
            awaited: low_priority_pool("explain", threads, messages)?,
            learning: low_priority_pool("learn", 1, messages)?,
            known,
            explanation,
            recovery,
            forgetting,
        };
        let (jobs, to_do) = mpsc::channel();
        thread::Builder::new()
            .name("explain".into())
            .spawn(move || bench.serve(&to_do, &done))?;
        Ok(Self { jobs })
    }

    /// Asks for a job to be done; the answer comes when it is, or never where it was an explanation
    /// and a later one was asked for before its turn came. Whether there is anybody to ask.
    #[must_use]
    pub fn ask(&self, job: Job) -> bool {
        self.jobs.send(job).is_ok()
    }
}

/// Threads of the lowest priority; everything parallel within a job stays in its pool.
fn low_priority_pool(
    name: &'static str,
    threads: usize,
    messages: &Messages,
) -> anyhow::Result<rayon::ThreadPool> {
    let messages = messages.clone();
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(move |index| format!("{name}-{index}"))
        .start_handler(move |index| {
            // An answer at ordinary priority is better than none.
            if let Err(error) = priority::lower_this_thread()
                && index == 0
            {
                messages.say(&format!("{name} at ordinary priority: {error}"));
            }
        });
    Ok(pool.build()?)
}

impl Bench {
    fn serve(&self, to_do: &Receiver<Job>, done: &Sender<Done>) {
        let mut waiting = Waiting::default();
        loop {
            if waiting.is_empty() {
                match to_do.recv() {
                    Ok(job) => waiting.sort_in(job),
                    Err(_) => return,
                }
            }
            for job in to_do.try_iter() {
                waiting.sort_in(job);
            }
            let answer = if let Some((request, sensing, robot)) = waiting.explanation.take() {
                self.explain(*request, sensing, &robot)
            } else if let Some(job) = waiting.recovery.take() {
                self.recover(&job)
            } else if let Some(job) = waiting.lessons.pop_front() {
                self.learn(&job)
            } else {
                continue;
            };
            if done.send(answer).is_err() {
                return;
            }
        }
    }

    fn explain(&self, request: Request, sensing: Sensing, robot: &Robot) -> Done {
        let (known, settings) = (&self.known, &self.explanation);
        let explained = self
            .awaited
            .install(|| explain_request(request, sensing, robot, known, settings));
        Done::Explained(Box::new(explained))
    }

    fn recover(&self, job: &RecoverJob) -> Done {
        let (known, settings) = (&self.known, &self.recovery);
        let found = self
            .awaited
            .install(|| job.done(known, &self.explanation, settings));
        Done::Recovered(found.map(Box::new))
    }

    fn learn(&self, job: &LearnJob) -> Done {
        let begin = Instant::now();
        let round = Round {
            gait: &self.known.gait,
            identification: &self.known.identification,
            explanation: &self.explanation,
            forgetting: self.forgetting,
            source: &self.known.source,
        };
        let corrected = |stretch: &WalkStretch| stretch.clone().corrected(&job.sensing);
        let (stretch, compared) = (corrected(&job.stretch), corrected(&job.compared));
        let outcome = self
            .learning
            .install(|| round.learn(&stretch, &compared, &job.known, job.before.as_deref()));
        Done::Learned(outcome, begin.elapsed())
    }
}

/// Jobs that wait for their turn.
#[derive(Default)]
struct Waiting {
    explanation: Option<(Box<Request>, Sensing, Arc<Robot>)>,
    recovery: Option<Box<RecoverJob>>,
    lessons: VecDeque<Box<LearnJob>>,
}

impl Waiting {
    fn is_empty(&self) -> bool {
        self.explanation.is_none() && self.recovery.is_none() && self.lessons.is_empty()
    }

    fn sort_in(&mut self, job: Job) {
        match job {
            Job::Explain(request, sensing, robot) => {
                self.explanation = Some((request, sensing, robot));
            }
            Job::Recover(job) => self.recovery = Some(job),
            Job::Learn(job) => self.lessons.push_back(job),
        }
    }
}
