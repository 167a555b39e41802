//! Puts the parts of the service together.

use std::{
    io,
    path::Path,
    sync::{
        Arc,
        atomic::AtomicBool,
        mpsc::{self, Receiver},
    },
    thread,
    time::{Duration, Instant},
};

use anyhow::Context;
use nalgebra::Vector3;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use super::{Service, lessons::Lessons};
use crate::{
    Settings,
    background::Background,
    event::WatchedRobot,
    monitor::{Monitor, MonitorSettings},
    output::{Events, Messages},
    recorder::Recorder,
    robot_model::RobotModel,
    saved_state::{SavedState, StateFile},
    sensor::Sensor,
    source::{self, Pulse, Source, SourceMessage},
    supervisor::Supervisor,
    worker::Worker,
};

/// Pieces of bytes on their way from the port, a few milliseconds each: four seconds, in
/// which the state file or a slow card may keep the daemon. Each is 4 kB at most.
const PIECES: usize = 1024;

impl Service {
    pub(super) fn start(settings: &Settings, messages: Messages) -> anyhow::Result<Self> {
        let source = settings.source()?;
        let known = Arc::new(RobotModel::new(settings, source.to_string())?);
        let (send_answer, answers) = mpsc::channel();
        let worker = Worker::new(settings, Arc::clone(&known), send_answer)?;
        let (send_done, done) = mpsc::channel();
        let (explains, learning) = (settings.explains(), settings.learning());
        let recovery_dir = settings.recovery_dir().map(Path::to_path_buf);
        let background = (explains || learning.is_some() || recovery_dir.is_some())
            .then(|| {
                let known = Arc::clone(&known);
                let explanation = settings.explanation.clone();
                let (recovery, forgetting) = (settings.recovery, settings.learning.forgetting);
                Background::new(
                    settings.answer_threads(),
                    known,
                    explanation,
                    recovery,
                    forgetting,
                    &messages,
                    send_done,
                )
            })
            .transpose()?;
        let identification = &settings.identification;
        let mut monitor = Monitor::new(MonitorSettings {
            motion: identification.motion,
            detector: identification.detector,
            window_s: identification.window_s,
            gait: known.gait.clone(),
            learning,
        })?;
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
            messages.say(&notice);
        }
        monitor.correct_for(state.sensing.unwrap_or_default());
        let dir = settings.state_dir.as_deref();
        let lessons = Lessons::start(settings.learning, &known, dir, &messages)?;
        let stop = Arc::new(AtomicBool::new(false));
        for signal in [SIGTERM, SIGINT, SIGHUP] {
            signal_hook::flag::register(signal, Arc::clone(&stop)).context("signals")?;
        }
        let source_name = source.to_string();
        let pulse = Pulse::default();
        let pieces = read_in_a_thread(source, &stop, &pulse)?;
        Ok(Self {
            events: Events::to_stdout(messages.clone()).context("stdout")?,
            source_name,
            robot: WatchedRobot::new(&known.robot),
            sensor: Sensor::new(settings, state.gyroscope_bias_radps.map(Vector3::from)),
            faulty: false,
            monitor,
            recorder: Recorder::new(&settings.record),
            state_file,
            state,
            supervisor: Supervisor::ready(messages.clone()),
            messages,
            status_every: Duration::from_secs_f64(settings.status_every_s),
            stop,
            pieces,
            pulse,
            answers,
            worker: Arc::new(worker),
            done,
            background,
            explains,
            recovery_dir,
            to_recover: None,
            lessons,
            begin: Instant::now(),
            last_heard: Instant::now(),
            processed: 0,
            last_attitude: None,
        })
    }
}

fn read_in_a_thread(
    source: Box<dyn Source>,
    stop: &Arc<AtomicBool>,
    pulse: &Pulse,
) -> io::Result<Receiver<SourceMessage>> {
    let (send, pieces) = mpsc::sync_channel(PIECES);
    let (stop, pulse) = (Arc::clone(stop), pulse.clone());
    thread::Builder::new()
        .name("source".into())
        .spawn(move || source::read(&*source, &stop, &pulse, &send))?;
    Ok(pieces)
}
