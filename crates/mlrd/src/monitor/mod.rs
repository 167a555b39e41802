//! The states of the daemon, without ports, clocks or threads.

mod cycle_tracker;
mod explainable_walk;
mod fluctuation_course;
mod handed_out;
mod healthy_walks;
mod recent;
mod request;
mod swings;

pub use handed_out::RequestNumber;
pub use request::{Request, WalkStretch};

use mlr_filter::{
    Assessment, Axes, DamageDetector, DetectorSettings, MotionSettings, MotionStart, SettingError,
};
use mlr_ga::WalkStart;
use mlr_model::Gait;
use mlr_residual::walk::Sensing;

use self::{
    cycle_tracker::CycleTracker,
    explainable_walk::{ExplainableWalk, WalkSeen},
    fluctuation_course::FluctuationCourse,
    handed_out::HandedOut,
    healthy_walks::HealthyWalks,
    recent::{PAUSE_S, Recent, Stretch},
    swings::{RecentSwings, differs},
};
use crate::{event::Kind, learning::LearningSettings, sensor::Reading, sensor_correction};

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
/// it has gone on for two windows of an identification, if its first step was seen: however long
/// that is ago, the phase of the gait is followed. While nothing is wrong, stretches of the walk are
/// offered to learn from.
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
    cycles: CycleTracker,
    healthy: Option<HealthyWalks>,
    handed_out: HandedOut,
    persistence_s: f64,
    /// What is corrected of the orientations that damage is looked for in.
    sensing: Sensing,
    /// When the walk started, where that was seen.
    motion_start_s: Option<f64>,
    next_check_s: f64,
    complained: bool,
    swings: RecentSwings,
    fluctuations: FluctuationCourse,
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
    /// Learn from this healthy walk, when there is time.
    Learn(Box<WalkStretch>),
}

/// What a monitor goes by.
#[derive(Debug, Clone)]
pub struct MonitorSettings {
    /// The search for the start of motion.
    pub motion: MotionSettings,
    /// The damage detector.
    pub detector: DetectorSettings,
    /// What an identification needs.
    pub window_s: f64,
    /// The gait that the robot walks.
    pub gait: Gait,
    /// Which healthy walk is offered to learn from; none where this is absent.
    pub learning: Option<LearningSettings>,
}

/// Seconds of orientation in which the start of a walk is looked for.
const SEARCH_S: f64 = 15.0;
/// How often the start or end of motion is looked for.
const CHECK_S: f64 = 0.5;
/// A robot that is still for so long stands.
const STILL_S: f64 = 3.0;
/// A robot that walks calmly for this long before it is damaged was healthy when it started.
const CALM_WALK_S: f64 = 3.0;
/// Damage is flagged so much later than the detector's persistence after it struck, at most.
const STRUCK_BEFORE_S: f64 = 1.0;

impl Monitor {
    /// Watches with these settings.
    ///
    /// # Errors
    /// [`SettingError`] when a setting makes no sense.
    pub fn new(settings: MonitorSettings) -> Result<Self, SettingError> {
        let MonitorSettings {
            motion,
            detector,
            window_s,
            gait,
            learning,
        } = settings;
        let fresh_detector = DamageDetector::new(detector)?;
        let healthy_s = learning.as_ref().map_or(0.0, HealthyWalks::keep_s);
        let keep_s = ExplainableWalk::keep_s(window_s).max(SEARCH_S);
        Ok(Self {
            motion,
            swinging_deg: detector.threshold_deg,
            persistence_s: detector.persistence_s,
            detector: fresh_detector.clone(),
            fresh_detector,
            window_s,
            recent: Recent::new(keep_s.max(healthy_s)),
            state: State::Standing,
            explainable: ExplainableWalk::None,
            cycles: CycleTracker::new(&gait),
            healthy: learning.map(HealthyWalks::new),
            handed_out: HandedOut::default(),
            sensing: Sensing::default(),
            motion_start_s: None,
            next_check_s: 0.0,
            complained: false,
            swings: RecentSwings::default(),
            fluctuations: FluctuationCourse::default(),
        })
    }

    /// What the sensor adds to orientations from now on, as far as it is known: damage is looked
    /// for without it.
    pub fn correct_for(&mut self, sensing: Sensing) {
        self.sensing = sensing;
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

    /// How roll and pitch fluctuate now: `None` where that is not known.
    pub fn fluctuation_deg(&self) -> Option<f64> {
        self.fluctuations.latest_deg()
    }

    /// Fluctuation that a healthy robot stays below.
    pub fn threshold_deg(&self) -> f64 {
        self.swinging_deg
    }

    /// The largest fluctuation of each whole second since this was last asked, the oldest first; of a
    /// minute at most.
    pub fn take_fluctuations_deg(&mut self) -> Vec<f64> {
        self.fluctuations.take_whole_seconds_deg()
    }

    /// Takes the next reading.
    pub fn take(&mut self, reading: &Reading) -> Vec<Action> {
        let attitude = reading.attitude;
        let mut actions = Vec::new();
        self.remember(reading);
        if attitude.time_s >= self.next_check_s {
            self.next_check_s = attitude.time_s + CHECK_S;
            self.check_motion(attitude.time_s, &mut actions);
        }
        if self.state == State::Walking {
            self.cycles.push(&attitude);
        }
        let Axes { roll, pitch, .. } =
            sensor_correction::corrected_tilt(attitude.angles_rad, &self.sensing);
        match self.detector.push(attitude.time_s, roll, pitch) {
            Ok(Some(assessment)) => {
                self.fluctuations
                    .push(assessment.time_s, assessment.fluctuation_deg);
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
        self.fluctuations.interrupt();
        self.explainable = ExplainableWalk::None;
        self.motion_start_s = None;
        self.cycles.forget();
        self.doubt_health(since_s);
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

    fn remember(&mut self, reading: &Reading) {
        if self.recent.push(*reading) {
            let now_s = reading.attitude.time_s;
            if let State::Flagged { since_s } = &mut self.state {
                *since_s = now_s;
            }
            self.explainable.begin_anew(now_s);
            if let Some(healthy) = &mut self.healthy {
                healthy.paused(now_s);
            }
        }
    }

    fn doubt_health(&mut self, now_s: f64) {
        if let Some(healthy) = &mut self.healthy {
            healthy.doubt(now_s);
        }
    }

    fn check_motion(&mut self, now_s: f64, actions: &mut Vec<Action>) {
        match self.state {
            State::Standing => {
                let found = self
                    .recent
                    .orientation(now_s - SEARCH_S)
                    .and_then(|recent| MotionStart::find(&recent, &self.motion).ok());
                if let Some(start) = found {
                    self.motion_start_s = start.stood_before.then_some(start.start_s);
                    self.cycles.forget();
                    if let Some(start_s) = self.motion_start_s {
                        self.cycles.begin(start_s);
                    }
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
                    .orientation(now_s - STILL_S)
                    .is_none_or(|recent| MotionStart::find(&recent, &self.motion).is_ok());
                if long_enough && !moves {
                    self.state = State::Standing;
                    self.motion_start_s = None;
                    self.cycles.forget();
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
                let within_s = since_s - PAUSE_S..=now_s;
                if let Some(recording) = self.recent.recording(within_s, Stretch::InMidWalk) {
                    let number = self.handed_out.next(now_s);
                    self.state = State::Identifying { number, swing_deg };
                    let start_s = self.cycles.cycle_start_s(since_s).or(self.motion_start_s);
                    actions.push(Action::Identify(Request {
                        number,
                        stretch: WalkStretch {
                            recording,
                            walk_start: start_s
                                .map_or(WalkStart::FoundInRecording, WalkStart::ObservedAtS),
                            motion_start_s: self.motion_start_s,
                            from_s: since_s,
                        },
                    }));
                }
            }
            State::Walking if fluctuation_deg < self.swinging_deg => {
                if let Some(healthy) = &mut self.healthy {
                    let cycle_start_s = |before_s| self.cycles.cycle_start_s(before_s);
                    let stretch =
                        healthy.walking(now_s, cycle_start_s, self.motion_start_s, &self.recent);
                    actions.extend(stretch.map(|stretch| Action::Learn(Box::new(stretch))));
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
            self.doubt_health(now_s);
            self.grow_explainable(now_s);
        }
    }

    fn grow_explainable(&mut self, now_s: f64) {
        if !self.explainable.is_due(now_s, self.window_s) {
            return;
        }
        let from_s = self.explainable.begins_s();
        let seen = WalkSeen {
            motion_start_s: self.motion_start_s,
            cycle_start_s: from_s.and_then(|from_s| self.cycles.cycle_start_s(from_s)),
        };
        self.explainable
            .take_down(now_s, seen, &self.recent, &mut self.handed_out);
    }

    fn flag(&mut self, now_s: f64) {
        let struck_s = now_s - self.persistence_s;
        self.cycles.doubt_since(struck_s - STRUCK_BEFORE_S);
        self.doubt_health(now_s);
        self.state = State::Flagged { since_s: now_s };
        let from_the_start = self
            .motion_start_s
            .filter(|start_s| struck_s - start_s < CALM_WALK_S);
        self.explainable = ExplainableWalk::Growing {
            from_s: from_the_start.unwrap_or(now_s),
        };
    }
}

#[cfg(test)]
mod tests;
