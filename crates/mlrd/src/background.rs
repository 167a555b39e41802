//! What is done when nothing else is to be done: explanations, and then learning.

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
use mlr_residual::walk::{EvidenceSettings, Sensing};

use crate::{
    explainer::{Explained, explain_request},
    learning::{LearnError, Outcome, Round},
    monitor::{Request, WalkStretch},
    output::Messages,
    priority,
    robot_model::RobotModel,
};

/// Does one thing after the other, on one thread of the lowest priority.
pub struct Background {
    jobs: Sender<Job>,
}

/// Something to be done. The sensor's faults are taken out of recordings first.
#[derive(Debug)]
pub enum Job {
    /// Explain a walk of a robot known like this. Those that are asked for later replace those that
    /// wait.
    Explain(Box<Request>, Sensing, Arc<Robot>),
    /// Learn from a walk. Explanations come first.
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
    /// A lesson, or why there is none, and how long it took.
    Learned(Result<Outcome, LearnError>, Duration),
}

/// What jobs are done with.
struct Bench {
    pool: rayon::ThreadPool,
    known: Arc<RobotModel>,
    explanation: EvidenceSettings,
    forgetting: f64,
}

impl Background {
    /// One that answers to `done`; a lesson forgets such a share of what was known before.
    ///
    /// # Errors
    /// When no thread is to be had.
    pub fn new(
        known: Arc<RobotModel>,
        explanation: EvidenceSettings,
        forgetting: f64,
        messages: Messages,
        done: Sender<Done>,
    ) -> anyhow::Result<Self> {
        let bench = Bench {
            // Everything parallel within a job stays in this pool.
            pool: rayon::ThreadPoolBuilder::new()
                .num_threads(1)
                .thread_name(|index| format!("explain-{index}"))
                .start_handler(move |_| {
                    // An explanation at ordinary priority is better than none.
                    if let Err(error) = priority::lower_this_thread() {
                        messages.say(&format!("explanations at ordinary priority: {error}"));
                    }
                })
                .build()?,
            known,
            explanation,
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

impl Bench {
    fn serve(&self, to_do: &Receiver<Job>, done: &Sender<Done>) {
        let (mut explanation, mut lessons) = (None, VecDeque::new());
        loop {
            if explanation.is_none() && lessons.is_empty() {
                match to_do.recv() {
                    Ok(job) => sort_in(job, &mut explanation, &mut lessons),
                    Err(_) => return,
                }
            }
            for job in to_do.try_iter() {
                sort_in(job, &mut explanation, &mut lessons);
            }
            let answer = match explanation.take() {
                Some((request, sensing, robot)) => self.explain(*request, sensing, &robot),
                None => match lessons.pop_front() {
                    Some(job) => self.learn(&job),
                    None => continue,
                },
            };
            if done.send(answer).is_err() {
                return;
            }
        }
    }

    fn explain(&self, request: Request, sensing: Sensing, robot: &Robot) -> Done {
        let (known, settings) = (&self.known, &self.explanation);
        let explained = self
            .pool
            .install(|| explain_request(request, sensing, robot, known, settings));
        Done::Explained(Box::new(explained))
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
            .pool
            .install(|| round.learn(&stretch, &compared, &job.known, job.before.as_deref()));
        Done::Learned(outcome, begin.elapsed())
    }
}

type Explanation = (Box<Request>, Sensing, Arc<Robot>);

fn sort_in(job: Job, explanation: &mut Option<Explanation>, lessons: &mut VecDeque<Box<LearnJob>>) {
    match job {
        Job::Explain(request, sensing, robot) => *explanation = Some((request, sensing, robot)),
        Job::Learn(job) => lessons.push_back(job),
    }
}
