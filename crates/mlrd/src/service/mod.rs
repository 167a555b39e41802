//! The loop of the daemon: bytes of the sensor in, events out.

mod conclusions;
mod lessons;
mod start;

use std::{
    io::{self, Write},
    path::PathBuf,
    process::ExitCode,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
        mpsc::{Receiver, RecvTimeoutError},
    },
    time::{Duration, Instant, SystemTime},
};

use mlr_recover::Diagnosis;
use nalgebra::Vector3;

use self::lessons::Lessons;
use crate::{
    Options,
    attitude::Attitude,
    background::{Background, Done},
    event::{Kind, Status, WatchedRobot},
    monitor::Monitor,
    output::{Events, Messages},
    recorder::{Recorder, RecordingNotice},
    saved_state::{SavedState, StateFile},
    sensor::{Heard, Reading, Sensor},
    sensor_fault::FaultChange,
    source::{Pulse, SourceMessage},
    supervisor::{Progress, Supervisor},
    worker::{Answer, Worker},
};

/// How long the daemon waits for bytes before it looks at anything else.
const TICK: Duration = Duration::from_millis(100);
/// How long bytes that have arrived are still taken when the daemon ends. With what the
/// outputs get after that, it ends within a second.
const LAST_BYTES: Duration = Duration::from_millis(250);
/// How long each output may take to write what is left then.
const LAST_LINES: Duration = Duration::from_millis(250);
/// Change of the gyroscope's bias that is worth writing down.
const BIAS_CHANGE_RADPS: f64 = 0.002;

/// Runs until SIGTERM, SIGINT or SIGHUP, or until standard input ends that is read.
pub fn run(options: &Options) -> ExitCode {
    let Ok(messages) = Messages::to_stderr() else {
        return ExitCode::FAILURE;
    };
    let started = match options.printed() {
        Ok(Some(text)) => return print(&text),
        Ok(None) => options.settings(),
        Err(error) => Err(error),
    };
    let started = started.and_then(|settings| Service::start(&settings, messages.clone()));
    let status = match started {
        Ok(service) => service.serve(),
        Err(error) => {
            messages.say(&format!("{error:#}"));
            ExitCode::from(2)
        }
    };
    messages.finish(LAST_LINES);
    status
}

/// Prints a text that was asked for in place of everything else. A reader who has seen enough of
/// it is no failure.
fn print(text: &str) -> ExitCode {
    let printed = io::stdout().lock().write_all(text.as_bytes());
    let is_fine = |error: &io::Error| error.kind() == io::ErrorKind::BrokenPipe;
    match printed.as_ref().map_or_else(is_fine, |()| true) {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    }
}

struct Service {
    events: Events,
    messages: Messages,
    source_name: String,
    robot: WatchedRobot,
    stop: Arc<AtomicBool>,
    pieces: Receiver<SourceMessage>,
    pulse: Pulse,
    answers: Receiver<Answer>,
    worker: Arc<Worker>,
    done: Receiver<Done>,
    background: Option<Background>,
    explains: bool,
    /// Where recovery gaits are written, if they are offered.
    recovery_dir: Option<PathBuf>,
    /// Damage that a gait is to be found for once it is explained.
    to_recover: Option<Diagnosis>,
    lessons: Lessons,
    sensor: Sensor,
    /// The sensor has a fault: what it says is recorded and not watched.
    faulty: bool,
    monitor: Monitor,
    recorder: Option<Recorder>,
    state_file: Option<StateFile>,
    state: SavedState,
    supervisor: Supervisor,
    status_every: Duration,
    begin: Instant,
    last_heard: Instant,
    processed: u64,
    last_attitude: Option<Attitude>,
}

impl Service {
    fn serve(mut self) -> ExitCode {
        self.tell(Kind::Started {
            port: self.source_name.clone(),
            robot: self.robot.clone(),
            last_known: self.state.last_known.clone(),
            calibration: self.lessons.known.known(),
        });
        let mut status = ExitCode::SUCCESS;
        let mut last_status = Instant::now();
        while !self.stop.load(Ordering::Relaxed) {
            let idle = match self.pieces.recv_timeout(TICK) {
                Ok(message) => {
                    self.hear(message);
                    false
                }
                Err(RecvTimeoutError::Timeout) => true,
                Err(RecvTimeoutError::Disconnected) => {
                    if !self.stop.load(Ordering::Relaxed) {
                        self.messages.say("the thread that reads the port has died");
                        status = ExitCode::FAILURE;
                    }
                    break;
                }
            };
            while let Ok(answer) = self.answers.try_recv() {
                self.answered(answer);
            }
            while let Ok(done) = self.done.try_recv() {
                match done {
                    Done::Explained(explained) => self.explained(*explained),
                    Done::Recovered(found) => self.recovered(found),
                    Done::Learned(outcome, busy) => self.learned(outcome, busy),
                }
            }
            self.learn_when_due();
            self.supervisor.feed(Progress {
                processed: self.processed,
                pulse: self.pulse.count(),
                idle,
            });
            if last_status.elapsed() >= self.status_every {
                last_status = Instant::now();
                self.report_status();
            }
        }
        self.end();
        status
    }

    fn end(&mut self) {
        self.supervisor.stopping();
        let end = Instant::now() + LAST_BYTES;
        while let Ok(message) = self
            .pieces
            .recv_timeout(end.saturating_duration_since(Instant::now()))
        {
            self.hear(message);
        }
        self.flush_recording();
        self.tell(Kind::Stopped);
        self.events.finish(LAST_LINES);
    }

    fn hear(&mut self, message: SourceMessage) {
        match message {
            SourceMessage::Opened => {
                self.sensor.reconnected();
                let port = self.source_name.clone();
                self.tell(Kind::PortOpened { port });
            }
            SourceMessage::Lost(reason) => self.tell(Kind::PortLost { reason }),
            SourceMessage::Bytes(arrived, bytes) => self.take(arrived, &bytes),
            SourceMessage::Ended => {
                // The last line may have no end of its own.
                self.take(Instant::now(), b"\n");
                self.stop.store(true, Ordering::Relaxed);
            }
        }
    }

    fn take(&mut self, arrived: Instant, bytes: &[u8]) {
        self.processed += 1;
        let arrival_s = arrived.duration_since(self.begin).as_secs_f64();
        let walking = self.monitor.expects_motion();
        for heard in self.sensor.take(arrival_s, bytes, walking) {
            match heard {
                Heard::Reading(reading) => {
                    self.last_heard = arrived;
                    self.read(&reading);
                }
                Heard::LineFault(fault) => {
                    let reason = fault.to_string();
                    self.tell(Kind::LineFault { reason });
                }
                Heard::Fault(change) => self.judge_sensor(change),
            }
        }
    }

    fn read(&mut self, reading: &Reading) {
        self.last_attitude = Some(reading.attitude);
        if let Some(recorder) = &mut self.recorder {
            match recorder.record(SystemTime::now(), reading) {
                Ok(notices) => self.tell_of_recordings(notices),
                Err(error) => self.end_recording(&error),
            }
        }
        if self.faulty {
            return;
        }
        for action in self.monitor.take(reading) {
            self.act(action);
        }
    }

    fn judge_sensor(&mut self, change: FaultChange) {
        match change {
            FaultChange::Began(fault) => {
                self.faulty = true;
                self.monitor.sensor_failed(fault.since_s);
                self.messages.say(&format!("sensor: {}", fault.reason));
                self.tell(Kind::SensorFault {
                    fault: fault.name,
                    reason: fault.reason,
                    since_s: fault.since_s,
                });
            }
            FaultChange::Over { name, lasted_s } => {
                self.faulty = false;
                self.tell(Kind::SensorRecovered {
                    fault: name,
                    lasted_s,
                });
            }
        }
    }

    fn report_status(&mut self) {
        let counts = self.sensor.counts();
        let state = self.monitor.state();
        let fault = self.sensor.fault().map(|fault| fault.name);
        self.supervisor.status(&format!(
            "{}; {} frames, {} bad, {} lost",
            fault.unwrap_or(state),
            counts.good,
            counts.bad,
            counts.lost
        ));
        self.flush_recording();
        self.keep_bias();
        let rate_hz = self.sensor.take_rate_hz();
        let angles = self.last_attitude.map(|attitude| attitude.angles_rad);
        let fluctuations_deg = self.monitor.take_fluctuations_deg();
        self.tell(Kind::Status(Box::new(Status {
            good: counts.good,
            bad: counts.bad,
            lost: counts.lost,
            state,
            fault,
            silent_s: self.last_heard.elapsed().as_secs_f64(),
            rate_hz,
            roll_deg: angles.map(|angles| angles.roll.to_degrees()),
            pitch_deg: angles.map(|angles| angles.pitch.to_degrees()),
            fluctuation_deg: self.monitor.fluctuation_deg(),
            fluctuations_deg,
            threshold_deg: self.monitor.threshold_deg(),
            dropped_status: 0,
            dropped_events: 0,
        })));
    }

    fn flush_recording(&mut self) {
        if let Some(Err(error)) = self.recorder.as_mut().map(Recorder::flush) {
            self.end_recording(&error);
        }
    }

    fn end_recording(&mut self, error: &io::Error) {
        self.recorder = None;
        self.warn(&format!("recording ends: {error}"));
    }

    fn keep_bias(&mut self) {
        let Some(bias) = self.sensor.gyroscope_bias_radps() else {
            return;
        };
        let kept = self.state.gyroscope_bias_radps.map(Vector3::from);
        if kept.is_some_and(|kept| (kept - bias).amax() < BIAS_CHANGE_RADPS) {
            return;
        }
        self.state.gyroscope_bias_radps = Some(bias.into());
        self.save();
    }

    /// A state that cannot be kept is no reason to end.
    fn save(&self) {
        if let Some(Err(error)) = self.state_file.as_ref().map(|file| file.save(&self.state)) {
            self.warn(&format!("state: {error}"));
        }
    }

    fn tell_of_recordings(&self, notices: Vec<RecordingNotice>) {
        for notice in notices {
            self.tell(match notice {
                RecordingNotice::Begun(path) => Kind::RecordingBegun { path },
                RecordingNotice::Removed(path) => Kind::RecordingRemoved { path },
            });
        }
    }

    fn warn(&self, reason: &str) {
        self.messages.say(reason);
        let reason = reason.to_string();
        self.tell(Kind::Warning { reason });
    }

    fn tell(&self, kind: Kind) {
        let t_s = self.last_attitude.map_or(0.0, |attitude| attitude.time_s);
        self.events.tell(SystemTime::now(), t_s, kind);
    }
}
