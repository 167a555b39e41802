//! Stories of walks.

use std::{f64::consts::TAU, ops::Range};

use mlr_imu::ImuSample;

use super::*;
use crate::attitude::Attitude;

fn monitor() -> Monitor {
    Monitor::new(MonitorSettings {
        motion: MotionSettings::default(),
        detector: DetectorSettings::default(),
        window_s: 5.0,
        gait: Gait::tripod(),
        learning: Some(LearningSettings::default()),
    })
    .unwrap()
}

/// A reading of nothing but the orientation.
fn shown(attitude: Attitude) -> Reading {
    Reading {
        attitude,
        sample: ImuSample::default(),
    }
}

/// Stands for 3 s, walks calmly, rocks from 12 s to 25 s, is calm again, and
/// stands from 30 s on.
fn story(t: f64) -> Attitude {
    walk(t, &(12.0..25.0), 30.0)
}

/// Stands for 3 s, walks until then, and rocks for some time of it.
fn walk(t: f64, rocking: &Range<f64>, until_s: f64) -> Attitude {
    let phase = (TAU * (t - 3.0)).sin();
    let roll_deg = match t {
        t if !(3.0..until_s).contains(&t) => 0.0,
        t if rocking.contains(&t) => 8.0 * phase,
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
        all.extend(
            monitor
                .take(&shown(story(t)))
                .into_iter()
                .map(|action| (t, action)),
        );
    }
    all
}

/// Whether it says when the walk of the story was observed to start.
fn starts_at_3_s(request: &Request) -> bool {
    matches!(request.stretch.walk_start, WalkStart::ObservedAtS(start_s) if (start_s - 3.0).abs() < 0.1)
}

/// Whether it says when a cycle of its gait of one second began.
fn starts_with_a_cycle(stretch: &WalkStretch) -> bool {
    let WalkStart::ObservedAtS(start_s) = stretch.walk_start else {
        return false;
    };
    (start_s - start_s.round()).abs() < 0.1
}

/// The first identification asked for.
fn identification(actions: &[(f64, Action)]) -> Option<&Request> {
    actions.iter().find_map(|(_, action)| match action {
        Action::Identify(request) => Some(request),
        _ => None,
    })
}

#[test]
fn from_standing_to_identified_and_back() {
    let mut monitor = monitor();
    let mut actions = run(&mut monitor, 0.0, 22.0);
    assert_eq!(monitor.state(), "identifying");
    let number = identification(&actions).unwrap().number;
    assert!(
        monitor.identified(number).is_none(),
        "nothing else is due yet"
    );
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
                    assert!(starts_with_a_cycle(&request.stretch));
                    assert!(
                        *request
                            .stretch
                            .recording
                            .orientation
                            .times_s()
                            .last()
                            .unwrap()
                            >= request.stretch.from_s + 5.0
                    );
                    "identify"
                }
                Action::Explain(request) => {
                    assert!(starts_at_3_s(request));
                    "explain"
                }
                Action::Learn(_) => panic!("the robot was flagged soon"),
            };
            (*t, name.to_string())
        })
        .collect();
    let names: Vec<&str> = told.iter().map(|(_, name)| name.as_str()).collect();
    assert_eq!(
        names,
        ["motion", "damage", "identify", "explain", "recovered"]
    );
    assert!((14.0..15.5).contains(&told[1].0), "{told:?}");
    let waited_s = told[3].0 - told[1].0;
    assert!((10.0..11.0).contains(&waited_s), "{told:?}");
    assert!((25.0..27.0).contains(&told[4].0), "{told:?}");
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
        for action in monitor.take(&shown(rocking(t))) {
            match action {
                Action::Identify(request) => {
                    asked_s.push(t);
                    monitor.identified(request.number);
                }
                Action::Report(Kind::DamageDetected { changed: true, .. }) => changes_s.push(t),
                Action::Explain(_) | Action::Report(_) | Action::Learn(_) => {}
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
    let from_s = identification(&actions).unwrap().stretch.from_s;
    assert!((from_s - 16.3).abs() < 0.01);
}

#[test]
fn a_fault_before_the_damage_is_flagged_leaves_nothing_of_it() {
    let mut monitor = monitor();
    // The body rocks for 1.9 s; half a second more, and it would be flagged.
    run(&mut monitor, 0.0, 13.9);
    assert_eq!(monitor.state(), "walking");
    monitor.sensor_failed(13.5);
    assert!(monitor.expects_motion());
    assert!(run(&mut monitor, 16.0, 17.9).is_empty());
    let flagged = run(&mut monitor, 17.9, 20.0);
    assert!(
        matches!(
            flagged[..],
            [(
                _,
                Action::Report(Kind::DamageDetected { changed: false, .. })
            )]
        ),
        "{flagged:?}"
    );
}

#[test]
fn an_identification_is_sound_unless_its_stretch_reaches_into_the_fault() {
    for (before_its_end_s, sound) in [(0.5, false), (-0.1, true)] {
        let mut monitor = monitor();
        let actions = run(&mut monitor, 0.0, 21.2);
        let request = identification(&actions).unwrap();
        let number = request.number;
        assert!(monitor.is_sound(number));
        let end_s = request
            .stretch
            .recording
            .orientation
            .times_s()
            .last()
            .unwrap();
        monitor.sensor_failed(end_s - before_its_end_s);
        assert_eq!(monitor.is_sound(number), sound);
        assert!(monitor.identified(number).is_none());
        assert_eq!(monitor.state(), "walking");
    }
}

#[test]
fn an_answer_to_an_earlier_request_does_not_pass_for_the_current_one() {
    let mut monitor = monitor();
    let rocking = |t: f64| walk(t, &(12.0..60.0), 70.0);
    let mut numbers = Vec::new();
    for i in 0..40 * 200 {
        let t = f64::from(i) / 200.0;
        if i == 25 * 200 {
            monitor.sensor_failed(t);
        }
        for action in monitor.take(&shown(rocking(t))) {
            if let Action::Identify(request) = action {
                numbers.push(request.number);
            }
        }
    }
    let [first, second] = numbers[..] else {
        panic!("{numbers:?}");
    };
    monitor.identified(first);
    assert_eq!(monitor.state(), "identifying");
    monitor.identified(second);
    assert_eq!(monitor.state(), "identified");
}

#[test]
fn samples_too_far_apart_are_complained_of_once() {
    let mut monitor = monitor();
    let complaints = (0..200)
        .flat_map(|i| monitor.take(&shown(story(f64::from(i) * 0.2))))
        .filter(|action| matches!(action, Action::Report(Kind::Unidentified { .. })))
        .count();
    assert_eq!(complaints, 1);
}

/// Lives through a walk whose identifications take so long; returns what is to be
/// explained, and when it was asked for.
fn explanations(rocking: &Range<f64>, until_s: f64, taking_s: f64) -> Vec<(f64, Request)> {
    let mut monitor = monitor();
    let mut asked = Vec::new();
    let mut done = None;
    for i in 0..90 * 200 {
        let t = f64::from(i) / 200.0;
        let mut actions = monitor.take(&shown(walk(t, rocking, until_s)));
        for action in &actions {
            if let Action::Identify(request) = action {
                done = Some((t + taking_s, request.number));
            }
        }
        if let Some((_, number)) = done.take_if(|(done_s, _)| t >= *done_s) {
            actions.extend(monitor.identified(number));
        }
        asked.extend(actions.into_iter().filter_map(|action| match action {
            Action::Explain(request) => Some((t, request)),
            _ => None,
        }));
    }
    asked
}

#[test]
fn an_explanation_is_asked_for_once_and_shows_the_robot_standing() {
    // An identification that takes long does not make it lose the stretch.
    for (taking_s, asked_s) in [(0.5, 24.0..26.0), (30.0, 49.0..51.0)] {
        let asked = explanations(&(12.0..80.0), 85.0, taking_s);
        let [(t, request)] = asked.as_slice() else {
            panic!("{} times", asked.len());
        };
        assert!(asked_s.contains(t), "{t}");
        let times_s = request.stretch.recording.orientation.times_s();
        let (first_s, last_s) = (times_s[0], times_s[times_s.len() - 1]);
        assert!(first_s <= 2.0, "{first_s}");
        assert!((14.0..15.5).contains(&request.stretch.from_s));
        assert!((10.0..11.0).contains(&(last_s - request.stretch.from_s)));
    }
}

#[test]
fn a_robot_that_calms_down_or_stops_too_early_is_not_explained() {
    for taking_s in [0.5, 7.0] {
        assert!(explanations(&(12.0..23.0), 85.0, taking_s).is_empty());
        assert!(explanations(&(12.0..80.0), 23.0, taking_s).is_empty());
    }
}

#[test]
fn damage_long_after_the_first_step_is_explained_with_the_phase_of_the_gait() {
    let asked = explanations(&(70.0..85.0), 88.0, 0.5);
    let [(t, request)] = asked.as_slice() else {
        panic!("{} times", asked.len());
    };
    assert!((82.0..84.0).contains(t), "{t}");
    let stretch = &request.stretch;
    assert!(starts_with_a_cycle(stretch));
    let start_s = stretch.walk_start.time_s().unwrap();
    assert!(
        (0.0..1.1).contains(&(stretch.from_s - start_s)),
        "{start_s}"
    );
    assert!((stretch.motion_start_s.unwrap() - 3.0).abs() < 0.1);
    // Healthy walk is handed over with it.
    let first_s = stretch.recording.orientation.times_s()[0];
    assert!(
        (11.5..12.5).contains(&(stretch.from_s - first_s)),
        "{first_s}"
    );
}

#[test]
fn a_robot_that_is_damaged_from_its_first_step_on_is_explained_from_there() {
    let asked = explanations(&(3.0..80.0), 85.0, 0.5);
    let [(t, request)] = asked.as_slice() else {
        panic!("{} times", asked.len());
    };
    assert!((13.0..14.0).contains(t), "{t}");
    assert!(starts_at_3_s(request));
    assert_eq!(
        request.stretch.walk_start.time_s(),
        Some(request.stretch.from_s)
    );
}

#[test]
fn a_walk_whose_first_step_was_not_seen_is_explained_by_what_is_seen() {
    let mut monitor = monitor();
    let mut asked = Vec::new();
    for i in 0..40 * 200 {
        // It walks when the daemon starts.
        for action in monitor.take(&shown(walk(
            20.0 + f64::from(i) / 200.0,
            &(35.0..60.0),
            70.0,
        ))) {
            match action {
                Action::Identify(request) => {
                    monitor.identified(request.number);
                }
                Action::Explain(request) => asked.push(request),
                Action::Report(Kind::Warning { reason }) => panic!("{reason}"),
                Action::Report(_) | Action::Learn(_) => {}
            }
        }
    }
    let [request] = asked.as_slice() else {
        panic!("{} times", asked.len());
    };
    let stretch = &request.stretch;
    assert_eq!(stretch.walk_start, WalkStart::FoundInRecording);
    assert_eq!(stretch.motion_start_s, None);
    // Nothing of the healthy walk is taken for the damaged one.
    let first_s = stretch.recording.orientation.times_s()[0];
    assert!((stretch.from_s - first_s).abs() < 0.01 && first_s > 35.0);
}

/// The stretches that are offered to learn from, and when.
fn lessons(rocking: &Range<f64>, until_s: f64) -> Vec<(f64, WalkStretch)> {
    let mut monitor = monitor();
    let mut offered = Vec::new();
    for i in 0..200 * 200 {
        let t = f64::from(i) / 200.0;
        for action in monitor.take(&shown(walk(t, rocking, until_s))) {
            if let Action::Learn(stretch) = action {
                offered.push((t, *stretch));
            }
        }
    }
    offered
}

#[test]
fn healthy_walks_are_offered_once_the_robot_has_walked_on() {
    let offered = lessons(&(0.0..0.0), 300.0);
    let times: Vec<f64> = offered.iter().map(|(t, _)| t.round()).collect();
    // 12 s from 3 s on, the end of every minute after that, each 30 s later.
    assert_eq!(times, [45.0, 105.0, 165.0]);
    let (_, first) = &offered[0];
    assert_eq!(first.walk_start.time_s(), Some(first.from_s));
    assert!((first.from_s - 3.0).abs() < 0.1);
    let times_s = first.recording.orientation.times_s();
    assert!(times_s[0] <= 2.0 && (14.9..16.0).contains(&times_s[times_s.len() - 1]));
    for (_, later) in &offered[1..] {
        assert!(starts_with_a_cycle(later) && later.walk_start.time_s() < Some(later.from_s));
        let times_s = later.recording.orientation.times_s();
        assert!((11.9..12.1).contains(&(times_s[times_s.len() - 1] - later.from_s)));
    }
}

#[test]
fn what_was_walked_shortly_before_a_flag_is_not_offered() {
    // The stretch from 3 s on would have been offered at 45 s.
    assert!(lessons(&(44.0..60.0), 70.0).is_empty());
    // A swing that is too short for a flag is reason enough.
    assert!(lessons(&(44.0..45.0), 70.0).is_empty());
    // A control: later it comes too late, and what was walked after it is not offered.
    let offered = lessons(&(46.0..60.0), 140.0);
    assert!((offered[0].1.from_s - 3.0).abs() < 0.1);
    assert!(offered.iter().skip(1).all(|(_, one)| one.from_s > 62.0));
    // Nor does a robot that stands walk on.
    assert!(lessons(&(0.0..0.0), 40.0).is_empty());
}

#[test]
fn what_the_gyroscope_makes_too_large_is_not_flagged_once_it_is_known() {
    let flagged = |sensing: Sensing| {
        let mut monitor = monitor();
        monitor.correct_for(sensing);
        (0..20 * 200).any(|i| {
            let t = f64::from(i) / 200.0;
            let shown_deg = if t < 3.0 { 0.0 } else { 2.8 * (TAU * t).sin() };
            let angles_rad = Axes {
                roll: f64::to_radians(shown_deg),
                pitch: 0.0,
                yaw: 0.0,
            };
            let actions = monitor.take(&shown(Attitude {
                time_s: t,
                angles_rad,
            }));
            let is_flag = |one: &Action| matches!(one, Action::Report(Kind::DamageDetected { .. }));
            actions.iter().any(is_flag)
        })
    };
    assert!(flagged(Sensing::default()));
    let scale = 0.85;
    assert!(!flagged(Sensing {
        scale,
        ..Sensing::default()
    }));
}

#[test]
fn what_could_not_be_identified_is_not_explained() {
    let mut monitor = monitor();
    let walk = |t: f64| walk(t, &(12.0..60.0), 70.0);
    for i in 0..60 * 200 {
        for action in monitor.take(&shown(walk(f64::from(i) / 200.0))) {
            match action {
                Action::Identify(request) => monitor.unidentified(request.number),
                Action::Explain(_) => panic!("nothing to explain"),
                Action::Report(_) | Action::Learn(_) => {}
            }
        }
    }
    assert_eq!(monitor.state(), "identified");
}
