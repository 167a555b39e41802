//! Puts port, sensor, monitor and identification together.

use std::{
    io::{self, Write},
    process::ExitCode,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
        mpsc::{self, Receiver, RecvTimeoutError, Sender},
    },
    thread,
    time::{Duration, Instant, SystemTime},
};

use anyhow::Context;
use mlr_ga::{AnswerError, Identification, IdentifySettings, Search, identify};
use mlr_model::{Gait, Robot};
use signal_hook::consts::{SIGINT, SIGTERM};

use crate::{
    Options,
    event::{self, Kind},
    monitor::{Action, Monitor, Request},
    port::{self, PortMessage},
    sensor::Sensor,
};

/// How often the daemon tells how it is.
const STATUS_EVERY: Duration = Duration::from_secs(10);
/// How long it waits for bytes before it looks at anything else.
const TICK: Duration = Duration::from_millis(100);

/// Runs until SIGTERM or SIGINT.
pub fn run(options: &Options) -> ExitCode {
    match Service::start(options).and_then(Service::serve) {
        Ok(()) => ExitCode::SUCCESS,
        // Whoever listened has gone: the end of the daemon, not a fault.
        Err(error)
            if error
                .downcast_ref::<io::Error>()
                .is_some_and(|cause| cause.kind() == io::ErrorKind::BrokenPipe) =>
        {
            ExitCode::SUCCESS
        }
        Err(error) => {
            let _ = writeln!(io::stderr().lock(), "mlrd: {error:#}");
            ExitCode::from(2)
        }
    }
}

struct Service {
    options: Options,
    stop: Arc<AtomicBool>,
    bytes: Receiver<PortMessage>,
    answers: Receiver<Result<Identification, AnswerError>>,
    worker: Arc<Worker>,
    sensor: Sensor,
    monitor: Monitor,
    begin: Instant,
    last_heard: Instant,
    /// Time of the last sample.
    now_s: f64,
}

/// Identifies on threads of its own.
struct Worker {
    pool: rayon::ThreadPool,
    seed: u64,
    settings: IdentifySettings,
    done: Sender<Result<Identification, AnswerError>>,
}

impl Service {
    fn start(options: &Options) -> anyhow::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        for signal in [SIGTERM, SIGINT] {
            signal_hook::flag::register(signal, Arc::clone(&stop)).context("signals")?;
        }
        let (send_bytes, bytes) = mpsc::channel();
        let (send_answer, answers) = mpsc::channel();
        let settings = IdentifySettings::default();
        let threads = options.threads.unwrap_or_else(|| {
            thread::available_parallelism().map_or(1, |cores| (cores.get() - 1).max(1))
        });
        let worker = Worker {
            pool: rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()?,
            seed: options.seed,
            settings: settings.clone(),
            done: send_answer,
        };
        let reader = (options.port.clone(), options.baud, Arc::clone(&stop));
        thread::Builder::new()
            .name("port".into())
            .spawn(move || port::read(&reader.0, reader.1, &reader.2, &send_bytes))?;
        Ok(Self {
            sensor: Sensor::new(options.format),
            monitor: Monitor::new(settings.motion, settings.detector, settings.window_s)?,
            options: options.clone(),
            stop,
            bytes,
            answers,
            worker: Arc::new(worker),
            begin: Instant::now(),
            last_heard: Instant::now(),
            now_s: 0.0,
        })
    }

    fn serve(mut self) -> anyhow::Result<()> {
        let port = self.options.port.clone();
        self.tell(&Kind::Started { port })?;
        let mut last_status = Instant::now();
        while !self.stop.load(Ordering::Relaxed) {
            match self.bytes.recv_timeout(TICK) {
                Ok(message) => self.hear(message)?,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            while let Ok(answer) = self.answers.try_recv() {
                self.monitor.identified();
                self.tell(&match answer {
                    Ok(result) => Kind::Identified {
                        result: Box::new(result),
                    },
                    Err(error) => Kind::Unidentified {
                        reason: error.to_string(),
                    },
                })?;
            }
            if last_status.elapsed() >= STATUS_EVERY {
                last_status = Instant::now();
                self.tell(&self.status())?;
            }
        }
        self.tell(&Kind::Stopped)
    }

    fn hear(&mut self, message: PortMessage) -> anyhow::Result<()> {
        match message {
            PortMessage::Opened => {
                let port = self.options.port.clone();
                self.tell(&Kind::PortOpened { port })
            }
            PortMessage::Lost(reason) => self.tell(&Kind::PortLost { reason }),
            PortMessage::Bytes(arrived, bytes) => {
                let arrival_s = arrived.duration_since(self.begin).as_secs_f64();
                let mut attitudes = Vec::new();
                self.sensor.take(arrival_s, &bytes, &mut attitudes);
                if !attitudes.is_empty() {
                    self.last_heard = arrived;
                }
                for attitude in attitudes {
                    self.now_s = attitude.time_s;
                    for action in self.monitor.take(attitude) {
                        match action {
                            Action::Report(kind) => self.tell(&kind)?,
                            Action::Identify(request) => Worker::identify(&self.worker, request),
                        }
                    }
                }
                Ok(())
            }
        }
    }

    fn status(&self) -> Kind {
        let counts = self.sensor.counts();
        Kind::Status {
            good: counts.good,
            bad: counts.bad,
            lost: counts.lost,
            state: self.monitor.state(),
            silent_s: self.last_heard.elapsed().as_secs_f64(),
        }
    }

    fn tell(&self, kind: &Kind) -> anyhow::Result<()> {
        let line = event::line(SystemTime::now(), self.now_s, kind)?;
        let mut stdout = io::stdout().lock();
        writeln!(stdout, "{line}")
            .and_then(|()| stdout.flush())
            .context("stdout")
    }
}

impl Worker {
    fn identify(worker: &Arc<Self>, request: Request) {
        let worker = Arc::clone(worker);
        thread::spawn(move || {
            let settings = IdentifySettings {
                motion_start_s: request.motion_start_s,
                from_s: Some(request.from_s),
                ..worker.settings.clone()
            };
            let search = Search::Genetic { repeats: 1 };
            let answer = worker.pool.install(|| {
                let (robot, gait) = (Robot::jethexa(), Gait::tripod());
                identify(
                    request.recording,
                    &robot,
                    &gait,
                    &settings,
                    search,
                    worker.seed,
                    &(),
                )
            });
            // Nobody listens any more when the daemon is ending.
            let _ = worker.done.send(answer);
        });
    }
}
