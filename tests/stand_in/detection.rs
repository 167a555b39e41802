use mlr_ga::{DetectionSettings, detect};

use crate::{only_raw_columns, recording, recording_of, truth::Truth};

/// The paper's detection figure: the damage of `detect-legs3-4` strikes at 19 s.
#[test]
fn notices_damage_and_nothing_else() {
    for (name, truth) in Truth::all() {
        let detection = detect(&recording(&name), &DetectionSettings::default()).unwrap();
        let start_s = detection.motion_start_s.unwrap();
        assert!(
            (start_s - truth.motion_start_s).abs() < 0.08,
            "{name}: {start_s}"
        );
        if truth.damaged_legs().is_empty() {
            assert_eq!(detection.damage_s, None, "{name}");
            continue;
        }
        let struck_s = match name.as_str() {
            "detect-legs3-4" => 19.0,
            _ => truth.motion_start_s,
        };
        let delay_s = detection.damage_s.unwrap() - struck_s;
        let slowest_s = if name == "detect-legs3-4" { 3.5 } else { 4.0 };
        assert!((2.0..slowest_s).contains(&delay_s), "{name}: {delay_s} s");
    }
}

/// Without the orientation that the plant's own filter wrote into the log, raw
/// samples of accelerometer and gyroscope give nearly the same.
#[test]
fn raw_samples_are_fused_into_the_orientation_that_was_logged() {
    let only_raw = only_raw_columns();
    for (name, truth) in Truth::all() {
        let logged = recording(&name).orientation;
        let fused = recording_of(&name, &only_raw).orientation;
        let walking = logged
            .times_s()
            .partition_point(|&t| t < truth.motion_start_s);
        // The logged orientation comes from another filter, with an error of its own.
        let apart_deg = |ours: &[f64], theirs: &[f64]| {
            let offset = ours[walking] - theirs[walking];
            let pairs = ours[walking..].iter().zip(&theirs[walking..]);
            let total: f64 = pairs.map(|(a, b)| (a - b - offset).abs()).sum();
            (total / (ours.len() - walking) as f64).to_degrees()
        };
        let (ours, theirs) = (fused.angles_rad(), logged.angles_rad());
        let roll = apart_deg(&ours.roll, &theirs.roll);
        let pitch = apart_deg(&ours.pitch, &theirs.pitch);
        let yaw = apart_deg(&ours.yaw, &theirs.yaw);
        assert!(
            roll < 0.6 && pitch < 1.5 && yaw < 2.0,
            "{name}: {roll} {pitch} {yaw}"
        );
    }
}
