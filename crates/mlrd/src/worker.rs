//! Identifies beside the reading.

use std::{
    io,
    panic::{self, AssertUnwindSafe},
    sync::{Arc, mpsc::Sender},
    thread,
    time::Instant,
};

use mlr_ga::{AnswerError, Identification, IdentificationReport, IdentifySettings, identify};
use mlr_model::Robot;
use mlr_residual::walk::Sensing;

use crate::{
    Settings,
    monitor::{Request, RequestNumber, WalkStretch},
    robot_model::RobotModel,
};

/// What an identification came to.
#[derive(Debug)]
pub struct Answer {
    /// Which request it answers.
    pub number: RequestNumber,
    /// The report, or why there is none.
    pub report: anyhow::Result<IdentificationReport>,
}

/// Identifies on threads of its own.
pub struct Worker {
    pool: rayon::ThreadPool,
    known: Arc<RobotModel>,
    done: Sender<Answer>,
}

impl Worker {
    /// A worker that answers to `done`.
    ///
    /// # Errors
    /// When no threads are to be had.
    pub fn new(
        settings: &Settings,
        known: Arc<RobotModel>,
        done: Sender<Answer>,
    ) -> anyhow::Result<Self> {
        Ok(Self {
            pool: rayon::ThreadPoolBuilder::new()
                .num_threads(settings.answer_threads())
                .thread_name(|index| format!("identify-{index}"))
                .build()?,
            known,
            done,
        })
    }

    /// Begins an identification of what this sensor recorded on a robot known like this; the
    /// answer comes when it is done.
    ///
    /// # Errors
    /// When no thread is to be had.
    pub fn identify(
        worker: &Arc<Self>,
        request: Request,
        sensing: Sensing,
        robot: Arc<Robot>,
    ) -> io::Result<()> {
        let worker = Arc::clone(worker);
        thread::Builder::new()
            .name("identify".into())
            .spawn(move || {
                let number = request.number;
                // The daemon waits for an answer, whatever becomes of the thread.
                let report = panic::catch_unwind(AssertUnwindSafe(|| {
                    worker.report(&request.stretch.corrected(&sensing), &robot)
                }));
                let report = match report {
                    Ok(report) => report.map_err(anyhow::Error::from),
                    Err(_) => Err(anyhow::anyhow!("the identification broke off")),
                };
                // Nobody listens any more when the daemon is ending.
                let _ = worker.done.send(Answer { number, report });
            })?;
        Ok(())
    }

    fn report(
        &self,
        stretch: &WalkStretch,
        robot: &Robot,
    ) -> Result<IdentificationReport, AnswerError> {
        let begin = Instant::now();
        let known = &self.known;
        let settings = IdentifySettings {
            walk_start: stretch.walk_start,
            from_s: Some(stretch.from_s),
            ..known.identification.clone()
        };
        let identification = self
            .pool
            .install(|| identify(&stretch.recording, known.model(robot), &settings, &()))?;
        Ok(IdentificationReport::new(
            known.source.clone(),
            Identification {
                // The settings may name a later cycle of the gait.
                motion_start_s: stretch.motion_start_s,
                ..identification
            },
            begin.elapsed(),
        ))
    }
}
