//! Identifies beside the reading.

use std::{
    sync::{Arc, mpsc::Sender},
    thread,
    time::Instant,
};

use mlr_ga::{
    AnswerError, IdentificationReport, IdentifySettings, Model, Search, atlas::Atlas, identify,
};
use mlr_model::{Gait, Robot};

use crate::{Settings, monitor::Request};

/// What an identification came to.
pub type Answer = Result<IdentificationReport, AnswerError>;

/// Identifies on threads of its own.
pub struct Worker {
    pool: rayon::ThreadPool,
    robot: Robot,
    gait: Gait,
    seed: u64,
    atlas: Option<Atlas>,
    settings: IdentifySettings,
    source: String,
    done: Sender<Answer>,
}

impl Worker {
    /// A worker that answers to `done`.
    ///
    /// # Errors
    /// When robot, gait or atlas cannot be read, or no threads are to be had.
    pub fn new(settings: &Settings, source: String, done: Sender<Answer>) -> anyhow::Result<Self> {
        let threads = settings.threads.unwrap_or_else(|| {
            thread::available_parallelism().map_or(1, |cores| (cores.get() - 1).max(1))
        });
        let (robot, gait) = (settings.robot()?, settings.gait()?);
        let atlas = settings
            .atlas
            .as_ref()
            .map(|path| Atlas::open(path, &robot, &gait, &settings.identification))
            .transpose()?;
        Ok(Self {
            pool: rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .thread_name(|index| format!("identify-{index}"))
                .build()?,
            robot,
            gait,
            atlas,
            seed: settings.seed,
            settings: settings.identification.clone(),
            source,
            done,
        })
    }

    /// Begins an identification; the answer comes when it is done.
    pub fn identify(worker: &Arc<Self>, request: Request) {
        let worker = Arc::clone(worker);
        thread::spawn(move || {
            let answer = worker.answer(request);
            // Nobody listens any more when the daemon is ending.
            let _ = worker.done.send(answer);
        });
    }

    fn answer(&self, request: Request) -> Answer {
        let begin = Instant::now();
        let settings = IdentifySettings {
            motion_start_s: request.motion_start_s,
            from_s: Some(request.from_s),
            ..self.settings.clone()
        };
        let search = match self.atlas {
            Some(_) => Search::Atlas,
            None => Search::Genetic { repeats: 1 },
        };
        let model = Model {
            robot: &self.robot,
            gait: &self.gait,
            atlas: self.atlas.as_ref(),
        };
        let identification = self
            .pool
            .install(|| identify(request.recording, model, &settings, search, self.seed, &()))?;
        Ok(IdentificationReport::new(
            self.source.clone(),
            search,
            self.seed,
            identification,
            begin.elapsed(),
        ))
    }
}
