//! Puts source, sensor, monitor and identification together.

use std::{
    io::{self, Write},
    process::ExitCode,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
        mpsc::{self, Receiver, RecvTimeoutError},
    },
    thread,
    time::{Duration, Instant, SystemTime},
};

use anyhow::Context;
use mlr_ga::ExplainError;
use nalgebra::Vector3;
use signal_hook::consts::{SIGINT, SIGTERM};

use crate::{
    Options, Settings,
    event::{self, Kind},
    explainer::{Explained, Explainer},
    monitor::{Action, Monitor},
    recorder::{Recorder, RecordingNotice},
    robot_model::RobotModel,
    saved_state::{KnownMorphology, SavedState, StateFile},
    sensor::Sensor,
    sensor_correction,
    source::{self, Pulse, Source, SourceMessage},
    supervisor::{Progress, Supervisor},
    worker::{Answer, Worker},
};

/// How long the daemon waits for bytes before it looks at anything else.
const TICK: Duration = Duration::from_millis(100);
/// Change of the gyroscope's bias that is worth writing down.
const BIAS_CHANGE_RADPS: f64 = 0.002;

/// Runs until SIGTERM or SIGINT.
pub fn run(options: &Options) -> ExitCode {
    let served = options
        .settings()
        .and_then(|settings| Service::start(&settings))
        .and_then(Service::serve);
    match served {
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
    source_name: String,
    stop: Arc<AtomicBool>,
    messages: Receiver<SourceMessage>,
    pulse: Pulse,
    answers: Receiver<Answer>,
    worker: Arc<Worker>,
    explanations: Receiver<Explained>,
    explainer: Option<Explainer>,
    sensor: Sensor,
    monitor: Monitor,
    recorder: Option<Recorder>,
    state_file: Option<StateFile>,
    state: SavedState,
    supervisor: Supervisor,
    status_every: Duration,
    begin: Instant,
    last_heard: Instant,
    processed: u64,
    /// Time of the last sample.
    now_s: f64,
}

impl Service {
    fn start(settings: &Settings) -> anyhow::Result<Self> {
        let source = settings.source()?;
        let known = Arc::new(RobotModel::new(settings, source.to_string())?);
        let (send_answer, answers) = mpsc::channel();
        let worker = Worker::new(settings, Arc::clone(&known), send_answer)?;
        let (send_explained, explanations) = mpsc::channel();
        let explainer = settings
            .explain
            .then(|| Explainer::new(known, settings.tracing.clone(), send_explained))
            .transpose()?;
        let identification = &settings.identification;
        let monitor = Monitor::new(
            identification.motion,
            identification.detector,
            identification.window_s,
        )?;
        let state_file = settings
            .state_dir
            .as_ref()
            .map(|dir| StateFile::new(dir).with_context(|| dir.display().to_string()))
            .transpose()?;
        let (state, notice) = match &state_file {
            Some(file) => file.load().context("state directory")?,
            None => (SavedState::default(), None),
        };
        if let Some(notice) = notice {
            let _ = writeln!(io::stderr().lock(), "mlrd: {notice}");
        }
        let stop = Arc::new(AtomicBool::new(false));
        for signal in [SIGTERM, SIGINT] {
            signal_hook::flag::register(signal, Arc::clone(&stop)).context("signals")?;
        }
        let source_name = source.to_string();
        let pulse = Pulse::default();
        let messages = read_in_a_thread(source, &stop, &pulse)?;
        Ok(Self {
            source_name,
            sensor: Sensor::new(settings, state.gyroscope_bias_radps.map(Vector3::from)),
            monitor,
            recorder: Recorder::new(&settings.record),
            state_file,
            state,
            supervisor: Supervisor::ready(),
            status_every: Duration::from_secs_f64(settings.status_every_s),
            stop,
            messages,
            pulse,
            answers,
            worker: Arc::new(worker),
            explanations,
            explainer,
            begin: Instant::now(),
            last_heard: Instant::now(),
            processed: 0,
            now_s: 0.0,
        })
    }

    fn serve(mut self) -> anyhow::Result<()> {
        self.tell(&Kind::Started {
            port: self.source_name.clone(),
            last_known: self.state.last_known.clone(),
        })?;
        let mut last_status = Instant::now();
        while !self.stop.load(Ordering::Relaxed) {
            let idle = match self.messages.recv_timeout(TICK) {
                Ok(message) => {
                    self.hear(message)?;
                    false
                }
                Err(RecvTimeoutError::Timeout) => true,
                Err(RecvTimeoutError::Disconnected) => break,
            };
            while let Ok(answer) = self.answers.try_recv() {
                self.answered(answer)?;
            }
            while let Ok(explained) = self.explanations.try_recv() {
                self.explained(explained)?;
            }
            self.supervisor.feed(Progress {
                processed: self.processed,
                pulse: self.pulse.count(),
                idle,
            });
            if last_status.elapsed() >= self.status_every {
                last_status = Instant::now();
                self.report_status()?;
            }
        }
        self.supervisor.stopping();
        if let Some(recorder) = &mut self.recorder
            && let Err(error) = recorder.flush()
        {
            self.warn(&format!("recording: {error}"))?;
        }
        self.tell(&Kind::Stopped)
    }

    fn hear(&mut self, message: SourceMessage) -> anyhow::Result<()> {
        match message {
            SourceMessage::Opened => {
                self.sensor.reconnected();
                let port = self.source_name.clone();
                self.tell(&Kind::PortOpened { port })
            }
            SourceMessage::Lost(reason) => self.tell(&Kind::PortLost { reason }),
            SourceMessage::Bytes(arrived, bytes) => self.take(arrived, &bytes),
        }
    }

    fn take(&mut self, arrived: Instant, bytes: &[u8]) -> anyhow::Result<()> {
        self.processed += 1;
        let arrival_s = arrived.duration_since(self.begin).as_secs_f64();
        let mut readings = Vec::new();
        if let Some(fault) = self.sensor.take(arrival_s, bytes, &mut readings) {
            let reason = fault.to_string();
            self.tell(&Kind::LineFault { reason })?;
        }
        if !readings.is_empty() {
            self.last_heard = arrived;
        }
        for reading in readings {
            self.now_s = reading.attitude.time_s;
            if let Some(recorder) = &mut self.recorder {
                match recorder.record(SystemTime::now(), &reading) {
                    Ok(notices) => self.tell_of_recordings(notices)?,
                    Err(error) => {
                        self.recorder = None;
                        self.warn(&format!("recording ends: {error}"))?;
                    }
                }
            }
            for action in self.monitor.take(reading.attitude) {
                self.act(action)?;
            }
        }
        Ok(())
    }

    fn act(&mut self, action: Action) -> anyhow::Result<()> {
        let sensing = self.state.sensing.unwrap_or_default();
        match action {
            Action::Report(kind) => self.tell(&kind),
            Action::Identify(request) => {
                Worker::identify(&self.worker, request, sensing);
                Ok(())
            }
            Action::Explain(request) => match &self.explainer {
                Some(explainer) if !explainer.explain(request, sensing) => {
                    self.explainer = None;
                    self.warn("explanations end: the thread that makes them has died")
                }
                _ => Ok(()),
            },
        }
    }

    fn answered(&mut self, answer: Answer) -> anyhow::Result<()> {
        match answer {
            Ok(report) => {
                let known = KnownMorphology::new(SystemTime::now(), &report.identification);
                self.state.last_known = Some(known);
                self.save()?;
                let result = Box::new(report);
                self.tell(&Kind::Identified { result })?;
                self.monitor
                    .identified()
                    .map_or(Ok(()), |next| self.act(next))
            }
            Err(error) => {
                self.monitor.unidentified();
                let reason = error.to_string();
                self.tell(&Kind::Unidentified { reason })
            }
        }
    }

    fn explained(&mut self, explained: Explained) -> anyhow::Result<()> {
        let Explained { report, corrected } = explained;
        let report = match report {
            Ok(report) => report,
            // Of the start that the monitor saw, the recording shows too little.
            Err(ExplainError::NoStart) => return Ok(()),
            Err(error) => return self.warn(&format!("explanation: {error}")),
        };
        let better = sensor_correction::known_better(corrected, &report.explanation);
        let result = Box::new(report);
        self.tell(&Kind::Explained { result })?;
        let Some(sensing) = better else {
            return Ok(());
        };
        self.state.sensing = Some(sensing);
        self.save()?;
        let _ = writeln!(
            io::stderr().lock(),
            "mlrd: sensor corrected from now on: {}",
            sensor_correction::in_words(&sensing)
        );
        self.tell(&Kind::SensorCorrected { sensing })
    }

    fn report_status(&mut self) -> anyhow::Result<()> {
        let counts = self.sensor.counts();
        let state = self.monitor.state();
        let silent_s = self.last_heard.elapsed().as_secs_f64();
        self.supervisor.status(&format!(
            "{state}; {} frames, {} bad, {} lost",
            counts.good, counts.bad, counts.lost
        ));
        if let Some(recorder) = &mut self.recorder
            && let Err(error) = recorder.flush()
        {
            self.recorder = None;
            self.warn(&format!("recording ends: {error}"))?;
        }
        self.keep_bias()?;
        self.tell(&Kind::Status {
            good: counts.good,
            bad: counts.bad,
            lost: counts.lost,
            state,
            silent_s,
        })
    }

    fn keep_bias(&mut self) -> anyhow::Result<()> {
        let Some(bias) = self.sensor.gyroscope_bias_radps() else {
            return Ok(());
        };
        let kept = self.state.gyroscope_bias_radps.map(Vector3::from);
        if kept.is_some_and(|kept| (kept - bias).amax() < BIAS_CHANGE_RADPS) {
            return Ok(());
        }
        self.state.gyroscope_bias_radps = Some(bias.into());
        self.save()
    }

    /// A state that cannot be kept is no reason to end.
    fn save(&self) -> anyhow::Result<()> {
        match self.state_file.as_ref().map(|file| file.save(&self.state)) {
            Some(Err(error)) => self.warn(&format!("state: {error}")),
            _ => Ok(()),
        }
    }

    fn tell_of_recordings(&self, notices: Vec<RecordingNotice>) -> anyhow::Result<()> {
        for notice in notices {
            self.tell(&match notice {
                RecordingNotice::Begun(path) => Kind::RecordingBegun { path },
                RecordingNotice::Removed(path) => Kind::RecordingRemoved { path },
            })?;
        }
        Ok(())
    }

    fn warn(&self, reason: &str) -> anyhow::Result<()> {
        let _ = writeln!(io::stderr().lock(), "mlrd: {reason}");
        let reason = reason.to_string();
        self.tell(&Kind::Warning { reason })
    }

    fn tell(&self, kind: &Kind) -> anyhow::Result<()> {
        let line = event::line(SystemTime::now(), self.now_s, kind)?;
        let mut stdout = io::stdout().lock();
        writeln!(stdout, "{line}")
            .and_then(|()| stdout.flush())
            .context("stdout")
    }
}

fn read_in_a_thread(
    source: Box<dyn Source>,
    stop: &Arc<AtomicBool>,
    pulse: &Pulse,
) -> io::Result<Receiver<SourceMessage>> {
    let (send, messages) = mpsc::channel();
    let (stop, pulse) = (Arc::clone(stop), pulse.clone());
    thread::Builder::new()
        .name("source".into())
        .spawn(move || source::read(&*source, &stop, &pulse, &send))?;
    Ok(messages)
}
