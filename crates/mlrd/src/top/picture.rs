//! What the events so far say, taken together.

use std::collections::VecDeque;

use mlr_model::Morphology;

use super::{
    saying,
    told::{Line, StatusTold, Told, What},
};
use crate::event::{Level, WatchedLeg, WatchedRobot};

/// Everything that is shown. It follows from the lines of the stream alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    pub(super) robot: WatchedRobot,
    pub(super) legs: Vec<LegCondition>,
    pub(super) port: Option<String>,
    pub(super) port_lost: Option<String>,
    /// Wall clock and time since the first sample of the last event.
    pub(super) time: String,
    pub(super) t_s: f64,
    pub(super) state: Option<String>,
    pub(super) status: StatusTold,
    /// Largest fluctuation of each second.
    pub(super) fluctuations_deg: VecDeque<f64>,
    /// Names of what is wrong, and the words for it.
    pub(super) sensor_fault: Option<(String, String)>,
    pub(super) line_fault: Option<String>,
    pub(super) damage: Option<Finding>,
    pub(super) explanation: Option<Finding>,
    pub(super) recovery: Option<Finding>,
    pub(super) calibration: Option<Finding>,
    pub(super) correction: Option<Finding>,
    pub(super) entries: VecDeque<Entry>,
    pub(super) stopped: bool,
}

/// What is known of a leg.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct LegCondition {
    pub(super) lost_links: usize,
    pub(super) damage_probability: Option<f64>,
}

/// A conclusion of the daemon.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Finding {
    pub(super) level: Level,
    pub(super) text: String,
}

/// A line of the list of events.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Entry {
    /// Time and level of an event; a line that is none has neither.
    pub(super) event: Option<(String, f64, Level)>,
    pub(super) text: String,
}

/// Seconds of fluctuation that are kept: more than any terminal is wide.
const KEPT_S: usize = 600;
/// A line is at fault after a longer silence.
const SILENT_S: f64 = 1.0;
/// Lines that are kept.
const KEPT_ENTRIES: usize = 1000;

impl Picture {
    /// Nothing is known yet. The robot is taken to be this one until the stream says.
    pub fn new(robot: WatchedRobot) -> Self {
        Self {
            legs: vec![LegCondition::default(); robot.legs.len()],
            robot,
            port: None,
            port_lost: None,
            time: String::new(),
            t_s: 0.0,
            state: None,
            status: StatusTold::default(),
            fluctuations_deg: VecDeque::new(),
            sensor_fault: None,
            line_fault: None,
            damage: None,
            explanation: None,
            recovery: None,
            calibration: None,
            correction: None,
            entries: VecDeque::new(),
            stopped: false,
        }
    }

    /// Takes the next line of the stream. Returns what it says.
    pub fn apply(&mut self, line: &Line) -> String {
        let (event, text) = match line {
            Line::Event(told) => {
                self.learn(told);
                let text = saying::saying(&told.name, &told.what, &self.robot.legs);
                (Some((told.time.clone(), told.t_s, told.level)), text)
            }
            Line::Other(text) => (None, text.clone()),
        };
        let entry = Entry { event, text };
        let said = entry.to_string();
        if !matches!(line, Line::Event(told) if matches!(told.what, What::Status(_))) {
            if self.entries.len() == KEPT_ENTRIES {
                self.entries.pop_front();
            }
            self.entries.push_back(entry);
        }
        said
    }

    fn learn(&mut self, told: &Told) {
        self.time.clone_from(&told.time);
        self.t_s = told.t_s;
        self.stopped = false;
        let level = told.level;
        let finding = |text: String| Some(Finding { level, text });
        match &told.what {
            What::Started {
                port,
                robot,
                last_known,
                calibration,
            } => {
                let robot = robot.as_ref().unwrap_or(&self.robot).clone();
                let entries = std::mem::take(&mut self.entries);
                *self = Self {
                    port: Some(port.clone()),
                    time: told.time.clone(),
                    entries,
                    ..Self::new(robot)
                };
                if let Some(known) = last_known {
                    self.is_left_with(&known.morphology, &[]);
                    let damage = saying::damage(&known.morphology, &self.robot.legs);
                    let text = format!("{damage}, as known before the start");
                    self.damage = finding(text);
                }
                if let Some(known) = calibration {
                    let walks = known.walks;
                    self.calibration = finding(format!(
                        "learned from {walks} healthy walks before the start"
                    ));
                }
            }
            What::PortOpened { port } => {
                self.port = Some(port.clone());
                self.port_lost = None;
                self.line_fault = None;
            }
            What::PortLost { reason } => self.port_lost = Some(reason.clone()),
            What::LineFault { reason } => self.line_fault = Some(reason.clone()),
            What::SensorFault { fault, reason } => {
                self.sensor_fault = Some((fault.clone(), reason.clone()));
            }
            What::SensorRecovered { .. } => self.sensor_fault = None,
            What::MotionStarted { .. } | What::Recovered => self.is("walking"),
            What::DamageDetected { .. } => self.is("flagged"),
            What::Identified { result } => {
                self.is("identified");
                self.is_left_with(&result.morphology, &result.leg_damage_probability);
                self.damage = finding(saying::identified(result, &self.robot.legs));
                // They belong to what was identified before.
                self.explanation = None;
                self.recovery = None;
            }
            What::Unidentified { reason } => {
                self.damage = finding(format!("not identified: {reason}"));
            }
            What::Explained { result } => self.explanation = finding(saying::explained(result)),
            What::RecoveryGait {
                gait,
                joints,
                result,
            } => {
                let files = saying::files(gait, joints);
                let outlook = saying::recovery(result);
                self.recovery = finding(format!("{files}; {outlook}"));
            }
            What::Calibrated {
                walks, gain_nats, ..
            } => self.calibration = finding(saying::calibrated(*walks, *gain_nats)),
            What::SensorCorrected { sensing } => {
                self.correction = finding(saying::corrected(sensing));
            }
            What::Status(status) => self.take_status(status),
            What::Stopped => self.stopped = true,
            What::Warning { .. }
            | What::RecordingBegun { .. }
            | What::RecordingRemoved { .. }
            | What::Unknown => {}
        }
    }

    fn is(&mut self, state: &str) {
        self.state = Some(state.into());
    }

    fn take_status(&mut self, status: &StatusTold) {
        self.is(&status.state);
        // Frames came before the fault as well.
        if status.good > self.status.good && status.silent_s < SILENT_S {
            self.line_fault = None;
        }
        match &status.fault {
            None => self.sensor_fault = None,
            Some(fault)
                if self
                    .sensor_fault
                    .as_ref()
                    .is_none_or(|(known, _)| known != fault) =>
            {
                self.sensor_fault = Some((fault.clone(), String::new()));
            }
            Some(_) => {}
        }
        let seconds = status.fluctuations_deg.iter();
        self.fluctuations_deg
            .extend(seconds.filter(|deg| deg.is_finite()));
        let too_many = self.fluctuations_deg.len().saturating_sub(KEPT_S);
        self.fluctuations_deg.drain(..too_many);
        self.status = status.clone();
    }

    fn is_left_with(&mut self, morphology: &Morphology, damage_probability: &[f64]) {
        if morphology.legs() != self.robot.legs.len() {
            // It is another robot than it was taken to be, and nothing else is known of it.
            self.robot = WatchedRobot {
                name: String::new(),
                legs: (0..morphology.legs())
                    .map(|leg| WatchedLeg {
                        name: String::new(),
                        // In pairs, from the front to the rear.
                        hip_m: [-((leg / 2) as f64), if leg % 2 == 0 { 1.0 } else { -1.0 }],
                        links: morphology.links(leg),
                    })
                    .collect(),
            };
        }
        self.legs = (0..morphology.legs())
            .map(|leg| LegCondition {
                lost_links: morphology.links(leg) - morphology.remaining(leg),
                damage_probability: damage_probability.get(leg).copied(),
            })
            .collect();
    }
}

impl std::fmt::Display for Entry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let text = &self.text;
        match &self.event {
            None => f.write_str(text),
            Some((time, t_s, level)) => {
                let (clock, level) = (saying::time_of_day(time), saying::level(*level));
                write!(f, "{clock}  {t_s:8.2} s  {level:<5}  {text}")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture_of(lines: &[&str]) -> Picture {
        let jethexa = WatchedRobot::new(&mlr_model::Robot::jethexa());
        let mut picture = Picture::new(jethexa);
        for line in lines {
            let (name, more) = line.split_once(' ').unwrap_or((line, ""));
            let comma = if more.is_empty() { "" } else { "," };
            let text = format!(r#"{{"time":"t","level":0,"event":"{name}"{comma}{more}}}"#);
            picture.apply(&Line::new(&text));
        }
        picture
    }

    #[test]
    fn the_state_follows_events_between_two_status() {
        let state = |lines: &[&str]| picture_of(lines).state.unwrap();
        let walking = r#"motion_started "motion_start_s":6.0"#;
        let flagged = r#"damage_detected "fluctuation_deg":9.0,"changed":false"#;
        assert_eq!(picture_of(&[]).state, None);
        assert_eq!(state(&[r#"status "state":"standing""#, walking]), "walking");
        assert_eq!(state(&[walking, flagged]), "flagged");
        assert_eq!(
            state(&[flagged, r#"status "state":"identifying""#]),
            "identifying"
        );
        assert_eq!(state(&[flagged, "recovered"]), "walking");
    }

    #[test]
    fn a_new_identification_ends_the_explanation_of_the_last() {
        let identified = r#"identified "result":{"morphology":[[1,1,1],[1,1,1],[0,0,0],[1,1,1],[1,1,1],[1,0,0]],"leg_damage_probability":[0,0,1,0,0,0.7]}"#;
        let explained = r#"explained "result":{"effects":[]}"#;
        let picture = picture_of(&[identified, explained]);
        assert!(picture.explanation.is_some());
        let lost: Vec<usize> = picture.legs.iter().map(|leg| leg.lost_links).collect();
        assert_eq!(lost, [0, 0, 3, 0, 0, 2]);
        assert_eq!(picture.legs[5].damage_probability, Some(0.7));
        let again = picture_of(&[identified, explained, identified]);
        assert_eq!(again.explanation, None);
    }

    #[test]
    fn a_robot_with_other_legs_is_taken_as_it_is() {
        let picture =
            picture_of(&[r#"identified "result":{"morphology":[[1,1],[1,1],[0,0],[1,1]]}"#]);
        assert_eq!((picture.legs.len(), picture.robot.legs.len()), (4, 4));
        assert_eq!(picture.legs[2].lost_links, 2);
    }

    #[test]
    fn faults_end_when_the_status_says_so() {
        let fault = r#"sensor_fault "fault":"frozen","reason":"the same again""#;
        let status = |fault: &str| format!(r#"status "state":"walking","good":5,"fault":{fault}"#);
        let frozen = picture_of(&[fault, &status("\"frozen\"")]);
        let expected = ("frozen".to_owned(), "the same again".to_owned());
        assert_eq!(frozen.sensor_fault, Some(expected));
        assert_eq!(picture_of(&[fault, &status("null")]).sensor_fault, None);
        let lost = r#"port_lost "reason":"unplugged""#;
        assert!(picture_of(&[lost, &status("null")]).port_lost.is_some());
        let opened = r#"port_opened "port":"/dev/ttyTHS1""#;
        assert_eq!(picture_of(&[lost, opened]).port_lost, None);
        let line = r#"line_fault "reason":"no frames""#;
        assert!(picture_of(&[line]).line_fault.is_some());
        assert_eq!(picture_of(&[line, &status("null")]).line_fault, None);
    }

    #[test]
    fn a_restart_forgets_what_was_known_of_the_sensor_and_keeps_the_events() {
        let picture = picture_of(&[
            r#"sensor_fault "fault":"frozen","reason":"the same again""#,
            r#"status "state":"walking","good":5,"fault":"frozen","fluctuations_deg":[1.0,2.0]"#,
            "stopped",
            r#"started "port":"/dev/ttyTHS1""#,
        ]);
        assert_eq!(picture.sensor_fault, None);
        assert!(picture.fluctuations_deg.is_empty() && !picture.stopped);
        assert_eq!(picture.entries.len(), 3);
    }
}
