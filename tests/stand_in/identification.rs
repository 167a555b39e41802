use std::collections::BTreeMap;

use mlr_ga::{Identification, IdentifySettings, Model, Search, identify};
use mlr_imu::Recording;
use mlr_model::Gait;

use crate::{
    from_s,
    model::{KNOWN, settings},
    only_raw_columns, recording, recording_of,
    truth::Truth,
};

/// The log whose robot loses legs 3 and 4 at 19 s.
const IN_MID_WALK: &str = "detect-legs3-4";

fn identified(recording: &Recording, model: Model<'_>, search: Search) -> Identification {
    let settings = IdentifySettings {
        search: Some(search),
        ..settings()
    };
    identify(recording, model, &settings, &()).unwrap()
}

/// The same answer by the genetic algorithm and by the atlas's own search, both on the walks of
/// the atlas. The log whose robot is damaged in mid-walk needs longer walks and is not among
/// them.
#[test]
fn names_the_damaged_legs_of_every_log() {
    let mut truths = Truth::all();
    truths.remove(IN_MID_WALK).unwrap();
    assert_eq!(truths.len(), 12);
    for search in [Search::Ga, Search::Atlas] {
        let answers = truths.keys().map(|name| {
            let answer = identified(&recording(name), KNOWN.with_atlas(), search);
            (name.as_str(), answer)
        });
        let answers: BTreeMap<&str, Identification> = answers.collect();
        for (name, answer) in &answers {
            assert_answered(name, &truths[*name], answer);
            let [warning] = &answer.warnings[..] else {
                panic!("{name}: {:?}", answer.warnings);
            };
            assert!(warning.contains("at most 2 damaged legs"), "{warning}");
            let least = match *name {
                "legs1-4-harsh" => 0.4,
                "legs2-3-lost" | "leg5-lost" => 0.8,
                _ => 0.95,
            };
            let sure = answer.legs_probability;
            assert!(sure > least, "{name}: {sure}");
        }
        let is_exact =
            |(name, answer): &(&&str, &Identification)| truths[**name].is_exactly(answer);
        let exact = answers.iter().filter(is_exact).count();
        assert!(exact >= 7, "down to the last link: {exact}");
        // No log's answer is right for a robot with other damaged legs.
        for (name, answer) in &answers {
            for (other, truth) in &truths {
                if truth.damaged_legs() != truths[*name].damaged_legs() {
                    assert!(!truth.is_answered_by(answer), "{name} as {other}");
                }
            }
        }
    }
}

fn assert_answered(name: &str, truth: &Truth, answer: &Identification) {
    let (found, listed) = (&answer.description, &answer.indistinguishable);
    assert!(truth.is_answered_by(answer), "{name}: {found}, {listed:?}");
    let late_s = answer.motion_start_s.unwrap() - truth.motion_start_s;
    assert!(late_s.abs() < 0.08, "{name}: walk found {late_s} s late");
}

/// Damage strikes a healthy robot at 19 s of the log and is flagged at 21 s.
#[test]
fn names_the_legs_lost_in_mid_walk() {
    let answer = identified(&recording(IN_MID_WALK), Model::jethexa(), Search::Ga);
    let truths = Truth::all();
    assert_answered(IN_MID_WALK, &truths[IN_MID_WALK], &answer);
    assert!(answer.legs_probability > 0.9);
    assert!((21.0..22.5).contains(&answer.window_start_s));
    assert_eq!(answer.warnings, Vec::<String>::new());
    assert!(!truths["legs2-3-lost"].is_answered_by(&answer));
}

/// The log begins while the damaged robot walks: the phase of its gait is fitted.
#[test]
fn names_the_lost_legs_in_a_log_cut_from_mid_walk() {
    let cut = from_s(&recording("legs2-3-lost").orientation, 5.37);
    let mut settings = settings();
    // The phase is fitted for each variation alike, and each takes time.
    settings.variations.truncate(1);
    let answer = identify(&cut.into(), Model::jethexa(), &settings, &()).unwrap();
    assert_eq!(answer.damaged_legs, [2, 3]);
    assert_eq!(answer.motion_start_s, None);
    assert!(answer.warnings[0].contains("phase of the gait"));
    // Some cycles later than it really started.
    let gait_start_s = answer.fit.gait_start_s.unwrap();
    let late_s = gait_start_s - Truth::all()["legs2-3-lost"].motion_start_s;
    let cycle_s = Gait::tripod().period_s;
    let off_s = late_s - (late_s / cycle_s).round() * cycle_s;
    assert!(off_s.abs() < 0.1, "{late_s}");
}

#[test]
fn raw_samples_name_the_damaged_legs() {
    let recording = recording_of("legs3-4-lost", &only_raw_columns());
    let answer = identified(&recording, KNOWN.with_atlas(), Search::Ga);
    assert_eq!(answer.damaged_legs, [3, 4]);
}
