//! The states of the daemon, without ports, clocks or threads.

mod explainable_walk;
mod handed_out;
mod recent;
mod request;
mod swings;

pub use handed_out::RequestNumber;
pub use request::Request;

use mlr_filter::{
    Assessment, Axes, DamageDetector, DetectorSettings, MotionSettings, MotionStart, SettingError,
};
use mlr_ga::WalkStart;

use self::{
    explainable_walk::ExplainableWalk,
    handed_out::HandedOut,
    recent::{PAUSE_S, Recent},
    swings::{RecentSwings, differs},
};
use crate::{attitude::Attitude, event::Kind};

/// Watches a stream of orientations.
///
/// ```text
/// standing ─► walking ─► flagged ─► identifying ─► identified
///     ▲          ▲          │ ▲                        │
///     │          │          │ └── moves otherwise ─────┤
///     └──────────┴──────────┴──── calm again ──────────┘
/// ```
///
/// A fault of the sensor ends everything but standing: a robot that walked is taken to
/// walk on, and is judged by what comes after the fault.
///
/// Beside these states, a walk that was flagged and identified is to be explained once
/// it has gone on for two windows of an identification, if its start is on record.
pub struct Monitor {
    motion: MotionSettings,
    detector: DamageDetector,
    /// A detector that has seen nothing.
    fresh_detector: DamageDetector,
    swinging_deg: f64,
    window_s: f64,
    recent: Recent,
    state: State,
    explainable: ExplainableWalk,
    handed_out: HandedOut,
    /// When the walk started, where that was seen.
    motion_start_s: Option<f64>,
    next_check_s: f64,
    complained: bool,
    swings: RecentSwings,
}

/// What the robot is known to do.
#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    Standing,
    Walking,
    Flagged {
        since_s: f64,
    },
    /// `swing_deg` is how far the body swung meanwhile.
    Identifying {
        number: RequestNumber,
        swing_deg: f64,
    },
    Identified {
        swing_deg: f64,
    },
}

/// What is to be done about a sample.
#[derive(Debug)]
pub enum Action {
    /// Tell.
    Report(Kind),
    /// Identify, without delaying the samples that follow.
    Identify(Request),
    /// Explain what was identified, when nothing else is to be done.
    Explain(Request),
}

/// Seconds of orientation in which the start of a walk is looked for.
const SEARCH_S: f64 = 15.0;
/// How often the start or end of motion is looked for.
const CHECK_S: f64 = 0.5;
/// A robot that is still for so long stands.
const STILL_S: f64 = 3.0;

impl Monitor {
    /// Watches with these settings; `window_s` is what an identification needs.
    ///
    /// # Errors
    /// [`SettingError`] when a setting makes no sense.
    pub fn new(
        motion: MotionSettings,
        detector: DetectorSettings,
        window_s: f64,
    ) -> Result<Self, SettingError> {
        let swinging_deg = detector.threshold_deg;
        let detector = DamageDetector::new(detector)?;
        Ok(Self {
            motion,
            swinging_deg,
            fresh_detector: detector.clone(),
            detector,
            window_s,
            recent: Recent::new(ExplainableWalk::keep_s(window_s).max(SEARCH_S)),
            state: State::Standing,
            explainable: ExplainableWalk::None,
            handed_out: HandedOut::default(),
            motion_start_s: None,
            next_check_s: 0.0,
            complained: false,
            swings: RecentSwings::default(),
        })
    }

    /// The state's name.
    pub fn state(&self) -> &'static str {
        match self.state {
            State::Standing => "standing",
            State::Walking => "walking",
            State::Flagged { .. } => "flagged",
            State::Identifying { .. } => "identifying",
            State::Identified { .. } => "identified",
        }
    }

    /// Takes the next orientation.
    pub fn take(&mut self, attitude: Attitude) -> Vec<Action> {
        let mut actions = Vec::new();
        self.remember(attitude);
        if attitude.time_s >= self.next_check_s {
            self.next_check_s = attitude.time_s + CHECK_S;
            self.check_motion(attitude.time_s, &mut actions);
        }
        let Axes { roll, pitch, .. } = attitude.angles_rad;
        match self.detector.push(attitude.time_s, roll, pitch) {
            Ok(Some(assessment)) => {
                self.judge(assessment, attitude.time_s, &mut actions);
                actions.extend(self.explanation_due());
            }
            Ok(None) => {}
            Err(error) => {
                if !self.complained {
                    let reason = error.to_string();
                    actions.push(Action::Report(Kind::Unidentified { reason }));
                }
                self.complained = true;
            }
        }
        actions
    }

    /// Whether the robot should be moving, as far as is known.
    pub fn expects_motion(&self) -> bool {
        self.state != State::Standing
    }

    /// The sensor's samples since then are worthless, and those that follow are not taken
    /// until it has recovered.
    pub fn sensor_failed(&mut self, since_s: f64) {
        self.handed_out.spoil_from(since_s);
        self.recent.clear();
        self.detector = self.fresh_detector.clone();
        self.swings = RecentSwings::default();
        self.explainable = ExplainableWalk::None;
        self.motion_start_s = None;
        if self.state != State::Standing {
            self.state = State::Walking;
        }
    }

    /// Whether what was handed out under this number contains no fault of the sensor.
    pub fn is_sound(&self, number: RequestNumber) -> bool {
        self.handed_out.is_sound(number)
    }

    /// The identification asked for is done; says what else is to be done now.
    pub fn identified(&mut self, number: RequestNumber) -> Option<Action> {
        if let State::Identifying {
            number: current,
            swing_deg,
        } = self.state
            && number == current
        {
            self.state = State::Identified { swing_deg };
        }
        self.explanation_due()
    }

    /// The identification asked for came to nothing.
    pub fn unidentified(&mut self, number: RequestNumber) {
        if matches!(self.state, State::Identifying { number: current, .. } if number == current) {
            self.explainable = ExplainableWalk::None;
        }
        self.identified(number);
    }

    fn explanation_due(&mut self) -> Option<Action> {
        match self.state {
            State::Identified { .. } => self.explainable.take().map(Action::Explain),
            _ => None,
        }
    }

    fn remember(&mut self, attitude: Attitude) {
        if self.recent.push(attitude) {
            if let State::Flagged { since_s } = &mut self.state {
                *since_s = attitude.time_s;
            }
            self.explainable.begin_anew(attitude.time_s);
        }
    }

    fn check_motion(&mut self, now_s: f64, actions: &mut Vec<Action>) {
        match self.state {
            State::Standing => {
                let found = self
                    .recent
                    .recording(now_s - SEARCH_S)
                    .and_then(|recent| MotionStart::find(&recent, &self.motion).ok());
                if let Some(start) = found {
                    self.motion_start_s = start.stood_before.then_some(start.start_s);
                    self.state = State::Walking;
                    actions.push(Action::Report(Kind::MotionStarted {
                        motion_start_s: start.start_s,
                    }));
                }
            }
            State::Walking => {
                let long_enough = self.recent.reaches_back_to(now_s - STILL_S);
                let moves = self
                    .recent
                    .recording(now_s - STILL_S)
                    .is_none_or(|recent| MotionStart::find(&recent, &self.motion).is_ok());
                if long_enough && !moves {
                    self.state = State::Standing;
                    self.motion_start_s = None;
                    // The next walk is looked for from here on.
                    self.recent.forget_before(now_s - STILL_S);
                }
            }
            State::Flagged { .. } | State::Identifying { .. } | State::Identified { .. } => {}
        }
    }

    fn judge(&mut self, assessment: Assessment, now_s: f64, actions: &mut Vec<Action>) {
        let Assessment {
            damaged,
            fluctuation_deg,
            ..
        } = assessment;
        let swing_deg = self.swings.mean_with(now_s, fluctuation_deg, self.window_s);
        match self.state {
            State::Standing | State::Walking if damaged => {
                self.flag(now_s);
                actions.push(Action::Report(Kind::DamageDetected {
                    fluctuation_deg,
                    changed: false,
                }));
            }
            State::Flagged { .. } | State::Identified { .. } if !damaged => {
                self.state = State::Walking;
                actions.push(Action::Report(Kind::Recovered));
            }
            State::Identified {
                swing_deg: known_deg,
            } if differs(swing_deg, known_deg) => {
                self.flag(now_s);
                actions.push(Action::Report(Kind::DamageDetected {
                    fluctuation_deg,
                    changed: true,
                }));
            }
            State::Identifying {
                swing_deg: known_deg,
                ..
            } if differs(swing_deg, known_deg) => self.explainable.interrupt(),
            State::Flagged { since_s } if now_s >= since_s + self.window_s => {
                if let Some(recording) = self.recent.recording(since_s - PAUSE_S) {
                    let number = self.handed_out.next(now_s);
                    self.state = State::Identifying { number, swing_deg };
                    actions.push(Action::Identify(Request {
                        number,
                        recording,
                        walk_start: self
                            .motion_start_s
                            .map_or(WalkStart::FoundInRecording, WalkStart::ObservedAtS),
                        from_s: since_s,
                    }));
                }
            }
            _ => {}
        }
        if !damaged {
            self.explainable.interrupt();
        }
        // The detector bears with a lull, in which the robot may have stopped: the stretch
        // ends where the body swings, or has within the detector's window.
        if fluctuation_deg >= self.swinging_deg {
            self.explainable.grow(
                now_s,
                self.window_s,
                self.motion_start_s,
                &self.recent,
                &mut self.handed_out,
            );
        }
    }

    fn flag(&mut self, now_s: f64) {
        self.state = State::Flagged { since_s: now_s };
        self.explainable = ExplainableWalk::Growing { from_s: now_s };
    }
}

#[cfg(test)]
mod tests;
