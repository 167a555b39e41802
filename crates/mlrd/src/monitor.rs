//! The states of the daemon, without ports, clocks or threads.

use std::collections::VecDeque;

use mlr_filter::{
    Axes, DamageDetector, DetectorError, DetectorSettings, MotionSettings, MotionStart,
    OrientationSeries,
};

use crate::{event::Kind, sensor::Attitude};

/// Watches a stream of orientations.
///
/// ```text
/// standing ─► walking ─► flagged ─► identifying ─► identified
///     ▲          ▲          │ ▲                        │
///     │          │          │ └── moves otherwise ─────┤
///     └──────────┴──────────┴──── calm again ──────────┘
/// ```
pub struct Monitor {
    motion: MotionSettings,
    detector: DamageDetector,
    window_s: f64,
    recent: VecDeque<Attitude>,
    state: State,
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
}

/// A stretch of the walk to identify.
#[derive(Debug, Clone)]
pub struct Request {
    /// The last seconds.
    pub recording: OrientationSeries,
    /// When the walk started, if known.
    pub motion_start_s: Option<f64>,
    /// Where the stretch to compare begins.
    pub from_s: f64,
}

/// The detector's fluctuations of the last seconds.
#[derive(Debug, Default)]
struct RecentSwings(VecDeque<(f64, f64)>);

impl RecentSwings {
    /// The mean over the last `window_s`, this one included.
    fn mean_with(&mut self, now_s: f64, fluctuation_deg: f64, window_s: f64) -> f64 {
        self.0.push_back((now_s, fluctuation_deg));
        self.0.retain(|(time_s, _)| now_s - time_s <= window_s);
        self.0.iter().map(|(_, swing_deg)| swing_deg).sum::<f64>() / self.0.len() as f64
    }
}

/// Whether the body swings so differently, averaged over some gait cycles, that
/// the damage must have changed: by a quarter and more than a degree.
fn differs(swing_deg: f64, known_deg: f64) -> bool {
    (swing_deg - known_deg).abs() > (0.25 * known_deg).max(1.0)
}

/// Seconds of orientation that are kept.
const KEEP_S: f64 = 15.0;
/// How often the start or end of motion is looked for.
const CHECK_S: f64 = 0.5;
/// A robot that is still for so long stands.
const STILL_S: f64 = 3.0;
/// A pause in the samples that spoils a stretch.
const PAUSE_S: f64 = 0.2;

impl Monitor {
    /// Watches with these settings; `window_s` is what an identification needs.
    ///
    /// # Errors
    /// [`DetectorError`] when a setting makes no sense.
    pub fn new(
        motion: MotionSettings,
        detector: DetectorSettings,
        window_s: f64,
    ) -> Result<Self, DetectorError> {
        Ok(Self {
            motion,
            detector: DamageDetector::new(detector)?,
            window_s,
            recent: VecDeque::new(),
            state: State::Standing,
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
            Ok(Some(assessment)) => self.judge(
                assessment.damaged,
                assessment.fluctuation_deg,
                attitude.time_s,
                &mut actions,
            ),
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

    /// The identification asked for is done, successfully or not.
    pub fn identified(&mut self) {
        if let State::Identifying { swing_deg } = self.state {
            self.state = State::Identified { swing_deg };
        }
    }

    fn remember(&mut self, attitude: Attitude) {
        let paused = self
            .recent
            .back()
            .is_some_and(|last| attitude.time_s - last.time_s > PAUSE_S);
        if let (true, State::Flagged { since_s }) = (paused, &mut self.state) {
            *since_s = attitude.time_s;
        }
        self.recent.push_back(attitude);
        while self
            .recent
            .front()
            .is_some_and(|first| first.time_s < attitude.time_s - KEEP_S)
        {
            self.recent.pop_front();
        }
    }

    fn check_motion(&mut self, now_s: f64, actions: &mut Vec<Action>) {
        match self.state {
            State::Standing => {
                let found = self
                    .recording(now_s - KEEP_S)
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
                let long_enough = self
                    .recent
                    .front()
                    .is_some_and(|first| first.time_s <= now_s - STILL_S);
                let moves = self
                    .recording(now_s - STILL_S)
                    .is_none_or(|recent| MotionStart::find(&recent, &self.motion).is_ok());
                if long_enough && !moves {
                    self.state = State::Standing;
                    self.motion_start_s = None;
                    // The next walk is looked for from here on.
                    self.recent.retain(|past| past.time_s >= now_s - STILL_S);
                }
            }
            State::Flagged { .. } | State::Identifying { .. } | State::Identified { .. } => {}
        }
    }

    fn judge(
        &mut self,
        damaged: bool,
        fluctuation_deg: f64,
        now_s: f64,
        actions: &mut Vec<Action>,
    ) {
        let swing_deg = self.swings.mean_with(now_s, fluctuation_deg, self.window_s);
        match self.state {
            State::Standing | State::Walking if damaged => {
                self.state = State::Flagged { since_s: now_s };
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
                self.state = State::Flagged { since_s: now_s };
                actions.push(Action::Report(Kind::DamageDetected {
                    fluctuation_deg,
                    changed: true,
                }));
            }
            State::Flagged { since_s } if now_s >= since_s + self.window_s => {
                if let Some(recording) = self.recording(since_s - PAUSE_S) {
                    self.state = State::Identifying { swing_deg };
                    actions.push(Action::Identify(Request {
                        recording,
                        motion_start_s: self.motion_start_s,
                        from_s: since_s,
                    }));
                }
            }
            _ => {}
        }
    }

    /// What is kept from `from_s` on.
    fn recording(&self, from_s: f64) -> Option<OrientationSeries> {
        let mut times_s = Vec::new();
        let mut angles_rad = Axes::<Vec<f64>>::default();
        for attitude in self.recent.iter().filter(|a| a.time_s >= from_s) {
            times_s.push(attitude.time_s);
            angles_rad.push(attitude.angles_rad);
        }
        OrientationSeries::new(times_s, angles_rad).ok()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    fn monitor() -> Monitor {
        Monitor::new(MotionSettings::default(), DetectorSettings::default(), 5.0).unwrap()
    }

    /// Stands for 3 s, walks calmly, rocks from 12 s to 25 s, is calm again, and
    /// stands from 30 s on.
    fn story(t: f64) -> Attitude {
        let phase = (TAU * (t - 3.0)).sin();
        let roll_deg = match t {
            t if !(3.0..30.0).contains(&t) => 0.0,
            t if (12.0..25.0).contains(&t) => 8.0 * phase,
            _ => 0.8 * phase,
        };
        Attitude {
            time_s: t,
            angles_rad: Axes {
                roll: roll_deg.to_radians(),
                pitch: 0.0,
                yaw: 0.0,
            },
        }
    }

    fn run(monitor: &mut Monitor, from_s: f64, to_s: f64) -> Vec<(f64, Action)> {
        let mut all = Vec::new();
        for i in (from_s * 500.0) as u32..(to_s * 500.0) as u32 {
            let t = f64::from(i) / 500.0;
            all.extend(monitor.take(story(t)).into_iter().map(|action| (t, action)));
        }
        all
    }

    #[test]
    fn from_standing_to_identified_and_back() {
        let mut monitor = monitor();
        let mut actions = run(&mut monitor, 0.0, 22.0);
        assert_eq!(monitor.state(), "identifying");
        monitor.identified();
        actions.extend(run(&mut monitor, 22.0, 40.0));
        let told: Vec<(f64, String)> = actions
            .iter()
            .map(|(t, action)| {
                let name = match action {
                    Action::Report(Kind::MotionStarted { motion_start_s }) => {
                        assert!(
                            (motion_start_s - 3.0).abs() < 0.1,
                            "{motion_start_s} at {t}"
                        );
                        "motion"
                    }
                    Action::Report(Kind::DamageDetected { .. }) => "damage",
                    Action::Report(Kind::Recovered) => "recovered",
                    Action::Report(other) => panic!("{other:?}"),
                    Action::Identify(request) => {
                        assert!((request.motion_start_s.unwrap() - 3.0).abs() < 0.1);
                        assert!(
                            *request.recording.times_s().last().unwrap() >= request.from_s + 5.0
                        );
                        "identify"
                    }
                };
                (*t, name.to_string())
            })
            .collect();
        let names: Vec<&str> = told.iter().map(|(_, name)| name.as_str()).collect();
        assert_eq!(names, ["motion", "damage", "identify", "recovered"]);
        assert!((14.0..15.5).contains(&told[1].0), "{told:?}");
        assert!((25.0..27.0).contains(&told[3].0), "{told:?}");
        assert_eq!(monitor.state(), "standing");
    }

    #[test]
    fn damage_that_changes_is_identified_again() {
        let rocking = |t: f64| {
            let swing_deg = match t {
                t if t < 30.0 => 4.0,
                t if t < 60.0 => 4.2,
                _ => 7.0,
            };
            Attitude {
                time_s: t,
                angles_rad: Axes {
                    roll: f64::to_radians(swing_deg) * (TAU * t).sin(),
                    pitch: 0.0,
                    yaw: 0.0,
                },
            }
        };
        let mut monitor = monitor();
        let mut asked_s = Vec::new();
        let mut changes_s = Vec::new();
        for i in 0..90 * 200 {
            let t = f64::from(i) / 200.0;
            for action in monitor.take(rocking(t)) {
                match action {
                    Action::Identify(_) => {
                        asked_s.push(t);
                        monitor.identified();
                    }
                    Action::Report(Kind::DamageDetected { changed: true, .. }) => changes_s.push(t),
                    Action::Report(_) => {}
                }
            }
        }
        assert!(asked_s[0] < 10.0, "{asked_s:?}");
        assert!((60.0..66.0).contains(&changes_s[0]), "{changes_s:?}");
        assert!(asked_s.iter().skip(1).all(|t| *t > 60.0), "{asked_s:?}");
        assert!(asked_s.len() >= 2);
    }

    #[test]
    fn a_pause_begins_the_stretch_anew() {
        let mut monitor = monitor();
        run(&mut monitor, 0.0, 16.0);
        assert_eq!(monitor.state(), "flagged");
        let actions = run(&mut monitor, 16.3, 24.0);
        let from_s = actions.iter().find_map(|(_, action)| match action {
            Action::Identify(request) => Some(request.from_s),
            Action::Report(_) => None,
        });
        assert!((from_s.unwrap() - 16.3).abs() < 0.01);
    }

    #[test]
    fn samples_too_far_apart_are_complained_of_once() {
        let mut monitor = monitor();
        let complaints = (0..200)
            .flat_map(|i| monitor.take(story(f64::from(i) * 0.2)))
            .filter(|action| matches!(action, Action::Report(Kind::Unidentified { .. })))
            .count();
        assert_eq!(complaints, 1);
    }
}
