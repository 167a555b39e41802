//! Several logs of one robot: likelihoods multiply, and what one log leaves open another tells.

use crate::program::Folder;
use mlr_filter::{Axes, OrientationSeries};
use mlr_ga::{
    AnswerError, IdentifySettings, LossHypothesis, MeasuredWalk, Objective, RecordedWalk,
    WalkObjective, WalkStart, identify_together,
    walks::{Case, SimulatedWalks, WalkSource},
};
use mlr_imu::{Recording, write_log};
use mlr_model::{
    Gait, JointTrajectory, LostLinks, Morphology, Motion, Outcome, Robot, SimulationSettings,
    Simulator, Variation,
};
use serde_json::Value;

/// The nominal model alone, and lost links gone.
fn settings() -> IdentifySettings {
    IdentifySettings {
        window_s: 3.0,
        lost_links: LossHypothesis::Absent,
        variations: vec![Variation::default()],
        ..IdentifySettings::default()
    }
}

/// Legs 1, 4 and 5 lift their feet and put them down again, and legs 2, 3 and 6 stand; or the
/// mirror image of it.
fn marching(robot: &Robot, mirrored: bool) -> Gait {
    let mut tripod = Gait::tripod();
    if let Some(feet) = tripod.feet_mut() {
        feet.stride_m = 0.002;
    }
    let both = JointTrajectory::commanded(robot, &tripod, 3.0).unwrap();
    let stance = both.rows_rad()[0].clone();
    let joints = |leg: usize| 3 * (leg - 1)..3 * leg;
    let rows = both.rows_rad().iter().map(|row| {
        let mut marching = stance.clone();
        for (leg, image) in [(1, 2), (4, 3), (5, 6)] {
            let lifting = if mirrored { image } else { leg };
            marching[joints(lifting)].copy_from_slice(&row[joints(leg)]);
        }
        marching
    });
    let joints = JointTrajectory::new(both.row_s(), rows.collect(), both.repeat_rows());
    Gait {
        name: if mirrored { "right" } else { "left" }.into(),
        period_s: 1.0,
        motion: Motion::Joints(joints.unwrap()),
    }
}

/// What the sensor of a robot without these legs records: a second of standing, then the gait.
fn recorded(robot: &Robot, gait: &Gait, legs_lost: &str) -> Recording {
    let settings = SimulationSettings {
        stand_s: 1.0,
        duration_s: 4.5,
        ..SimulationSettings::default()
    };
    let simulator = Simulator::new(robot.clone(), gait, settings).unwrap();
    let Outcome::Walked(walked) = simulator.simulate(&without(robot, legs_lost)) else {
        panic!("diverged");
    };
    walked.orientation.into()
}

fn without(robot: &Robot, legs: &str) -> Morphology {
    Morphology::parse_legs_lost(legs, &robot.layout()).unwrap()
}

/// A measured walk and the walks of candidates with the same gait.
fn compared(robot: &Robot, gait: &Gait, recording: &Recording) -> (MeasuredWalk, SimulatedWalks) {
    let settings = settings();
    let measured = MeasuredWalk::new(recording, gait, &settings).unwrap();
    let nominal = Case {
        lost_links: LostLinks::Absent,
        variation: 0,
    };
    let walks = SimulatedWalks::new(
        robot,
        gait,
        &settings.simulation,
        [nominal],
        &settings.variations,
        measured.stretch().walk_samples(),
        &measured.stretch().looks(),
    );
    (measured, walks.unwrap())
}

/// Of a robot without legs 3 and 4, each of two marches shows the leg that it stands on.
#[test]
fn two_logs_tell_together_what_neither_tells_alone() {
    let robot = Robot::jethexa();
    let logs = [false, true].map(|mirrored| {
        let gait = marching(&robot, mirrored);
        compared(&robot, &gait, &recorded(&robot, &gait, "3,4"))
    });
    let settings = settings();
    let of = |logs: &[&(MeasuredWalk, SimulatedWalks)]| -> Vec<f64> {
        let each = logs
            .iter()
            .map(|(measured, walks)| (measured, walks as &dyn WalkSource));
        let objective = WalkObjective::of_logs(each, &settings);
        ["", "4", "3", "3,4"]
            .map(|legs| {
                let cost_deg = objective
                    .evaluate(&without(&robot, legs), f64::INFINITY)
                    .cost_deg;
                objective.ln_weight_of_cost(cost_deg)
            })
            .to_vec()
    };
    let best = |ln_weights: &[f64]| {
        let indices = 0..ln_weights.len();
        indices
            .max_by(|a, b| ln_weights[*a].total_cmp(&ln_weights[*b]))
            .unwrap()
    };
    let [left, right] = [of(&[&logs[0]]), of(&[&logs[1]])];
    let both = of(&[&logs[0], &logs[1]]);
    assert_eq!(best(&left), 2, "leg 3, on which it stands: {left:?}");
    assert_eq!(best(&right), 1, "leg 4: {right:?}");
    assert_eq!(best(&both), 3, "both: {both:?}");
    assert!((0..3).all(|other| both[3] - both[other] > 4.0), "{both:?}");
    // Likelihoods multiply, and the prior counts once.
    for (index, legs) in ["", "4", "3", "3,4"].into_iter().enumerate() {
        let ln_prior = settings.prior.ln(&without(&robot, legs));
        let sum = left[index] + right[index] - ln_prior;
        assert!(
            (both[index] - sum).abs() < 1e-9,
            "{legs}: {} {sum}",
            both[index]
        );
    }
    // What one log speaks against beyond hope is given up, whatever the other says.
    let each = logs
        .iter()
        .map(|(measured, walks)| (measured, walks as &dyn WalkSource));
    let objective = WalkObjective::of_logs(each, &settings);
    let limit_deg = objective.cost_of_ln_weight(both[3]);
    let evaluation = objective.evaluate(&without(&robot, "2,6"), limit_deg);
    assert!(
        evaluation.abandoned && evaluation.fits.len() < 2,
        "{evaluation:?}"
    );
}

#[test]
fn a_time_of_one_log_is_no_setting_of_several() {
    let robot = Robot::jethexa();
    let gait = marching(&robot, false);
    let recording = recorded(&robot, &gait, "");
    let walk = RecordedWalk {
        recording: &recording,
        gait: &gait,
        atlas: None,
    };
    let refused = |walks: &[RecordedWalk<'_>], settings: &IdentifySettings| {
        let (_, error) = identify_together(walks, &robot, settings, &()).unwrap_err();
        error
    };
    let from = IdentifySettings {
        from_s: Some(1.5),
        ..settings()
    };
    let commanded = IdentifySettings {
        walk_start: WalkStart::CommandedAtS(1.0),
        ..settings()
    };
    for (settings, name) in [(&from, "from_s"), (&commanded, "walk_start.commanded_at_s")] {
        let message = refused(&[walk, walk], settings).to_string();
        assert!(
            message.contains(name) && message.contains("2 logs"),
            "{message}"
        );
    }
    assert!(matches!(refused(&[], &settings()), AnswerError::NoLogs));
    // A log that cannot answer is named by its index.
    let times_s: Vec<f64> = (0..900).map(|i| f64::from(i) * 0.005).collect();
    let level = Axes::from_fn(|_| vec![0.0; times_s.len()]);
    let still = Recording::from(OrientationSeries::new(times_s, level).unwrap());
    let walks = [
        walk,
        RecordedWalk {
            recording: &still,
            ..walk
        },
    ];
    let (index, error) = identify_together(&walks, &robot, &settings(), &()).unwrap_err();
    assert!(
        index == 1 && error.is_recordings_fault(),
        "{index}: {error}"
    );
}

#[test]
fn the_program_answers_from_all_logs_and_says_what_each_is_worth() {
    let folder = Folder::new();
    let robot = Robot::jethexa();
    let config = folder.write(
        "quick.toml",
        "window_s = 3.0\nlost_links = \"absent\"\nvariations = [{}]\n\
         [genetic]\nislands = 1\npopulation = 8\ngenerations = 1\ncomplete = false\n",
    );
    let tripod = folder.path("tripod.csv");
    folder.succeeds(&[
        "simulate",
        "-o",
        &tripod,
        "--walk-s",
        "4",
        "--legs-lost",
        "3",
    ]);
    let gait = marching(&robot, false);
    let left = folder.path("left.csv");
    let recording = recorded(&robot, &gait, "3");
    write_log(std::path::Path::new(&left), &recording.orientation).unwrap();
    let march = folder.write("left.toml", gait.to_toml());
    let common = ["identify", "--config", &config, "--json"];
    let of = |more: &[&str]| -> Value {
        serde_json::from_str(&folder.succeeds(&[&common[..], more].concat())).unwrap()
    };
    let both = of(&[&tripod, &left, "--gait", "tripod", "--gait", &march]);
    assert_eq!(both["schema"], "mlr.identification/1");
    assert_eq!(both["log"], Value::from(tripod.clone()));
    assert_eq!(both["damaged_legs"], Value::from(vec![3]));
    let logs = both["logs"].as_array().unwrap();
    assert_eq!(logs.len(), 2);
    assert_eq!(logs[1]["file"], Value::from(left.clone()));
    assert_eq!(logs[1]["gait"], "left");
    assert!(
        logs.iter()
            .all(|log| log["warnings"] == Value::Array(Vec::new()))
    );
    assert!(logs[0]["motion_start_s"].as_f64().unwrap() > 1.9);
    let number = |of: &Value, name: &str| of[name].as_f64().unwrap();
    let sum: f64 = logs.iter().map(|log| number(log, "cost_rad")).sum();
    assert!((number(&both, "cost_rad") - sum).abs() < 1e-9);
    let mean: f64 = logs
        .iter()
        .map(|log| number(log, "mean_error_deg"))
        .sum::<f64>()
        / 2.0;
    assert!((number(&both, "mean_error_deg") - mean).abs() < 1e-9);
    // The control: one log is answered as before, without a list of logs.
    let one = of(&[&tripod]);
    assert!(one.get("logs").is_none());
    assert!((number(&one, "cost_rad") - sum).abs() > 1e-6);

    let table = folder.succeeds(&[
        "identify",
        &tripod,
        &tripod,
        "--config",
        &config,
        "--method",
        "paper",
        "--repeats",
        "2",
    ]);
    assert!(table.contains("\nsearch"), "{table}");
    let fails = |more: &[&str], status: i32, message: &[&str]| {
        folder.fails(&[&common[..], more].concat(), status, message);
    };
    let gaits = ["--gait", "tripod", "--gait", &march, "--gait", "tripod"];
    fails(
        &[&[tripod.as_str(), &left], &gaits[..]].concat(),
        2,
        &["3 gaits for 2 logs"],
    );
    fails(&[&tripod, &left, "--from-s", "2"], 2, &["from_s", "2 logs"]);
    fails(
        &[
            &tripod, &left, "--gait", "tripod", "--gait", &march, "--search", "atlas",
        ],
        2,
        &["no atlas", "--search ga"],
    );
    let empty = folder.write(
        "empty.csv",
        crate::program::standing_then_rocking(3.0, 4.0, 200.0),
    );
    fails(&[&tripod, &empty], 1, &["empty.csv"]);
}
