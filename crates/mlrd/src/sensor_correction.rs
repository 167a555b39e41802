//! What explanations find of the sensor, and what is made of it.

use mlr_filter::Axes;
use mlr_imu::{RawSeries, Recording};
use mlr_residual::walk::{Sensing, WalkExplanation};
use nalgebra::{UnitQuaternion, Vector3};

/// Angles, rates, scales and delays below these make no difference.
const LEAST_TILT_DEG: f64 = 0.2;
const LEAST_BIAS_DPS: f64 = 0.1;
const LEAST_SCALE: f64 = 0.005;
const LEAST_DELAY_S: f64 = 0.005;

/// The sensor as known from now on, if what an explanation found of it makes a
/// difference. `corrected` is what its recording was rid of beforehand.
pub(crate) fn known_better(corrected: Sensing, explanation: &WalkExplanation) -> Option<Sensing> {
    let found = explanation.sensing();
    let mut known = corrected.and(&found);
    // Biases about x and y are not taken from a recording, where the sensor's own filter
    // all but removes them: what is found of them is found again, not added.
    for axis in 0..2 {
        known.bias_dps[axis] = match found.bias_dps[axis] {
            0.0 => corrected.bias_dps[axis],
            found_dps => found_dps,
        };
    }
    differs(&known, &corrected).then_some(known)
}

/// What the sensor recorded, without what it adds to the body's orientation, rates and forces. Its
/// delay moves all times.
pub(crate) fn corrected(recording: Recording, sensing: &Sensing) -> Recording {
    Recording {
        orientation: sensing.correct(&recording.orientation),
        raw: recording.raw.map(|raw| corrected_raw(raw, sensing)),
        ..recording
    }
}

/// Biases about x and y stay in, as in the orientation.
fn corrected_raw(mut raw: RawSeries, sensing: &Sensing) -> RawSeries {
    let [roll_rad, pitch_rad, _] = sensing.misalignment_deg.map(f64::to_radians);
    let on_body = UnitQuaternion::from_euler_angles(roll_rad, pitch_rad, 0.0);
    let [_, _, bias_z_dps] = sensing.bias_dps;
    let bias_radps = Vector3::z() * bias_z_dps.to_radians();
    for acceleration in &mut raw.accelerations_mps2 {
        *acceleration = on_body * *acceleration;
    }
    for rate in &mut raw.angular_rates_radps {
        *rate = on_body * ((*rate - bias_radps) * sensing.scale);
    }
    for time_s in &mut raw.times_s {
        *time_s -= sensing.delay_s;
    }
    raw
}

/// Roll and pitch of one moment, in the same way; yaw as it is.
pub(crate) fn corrected_tilt(angles_rad: Axes<f64>, sensing: &Sensing) -> Axes<f64> {
    let [roll_rad, pitch_rad, _] = sensing.misalignment_deg.map(f64::to_radians);
    Axes {
        roll: sensing.scale * (angles_rad.roll - roll_rad),
        pitch: sensing.scale * (angles_rad.pitch - pitch_rad),
        yaw: angles_rad.yaw,
    }
}

fn differs(one: &Sensing, other: &Sensing) -> bool {
    let far =
        |a: &[f64], b: &[f64], least: f64| a.iter().zip(b).any(|(a, b)| (a - b).abs() >= least);
    far(
        &one.misalignment_deg,
        &other.misalignment_deg,
        LEAST_TILT_DEG,
    ) || far(&one.bias_dps, &other.bias_dps, LEAST_BIAS_DPS)
        || far(&[one.scale / other.scale], &[1.0], LEAST_SCALE)
        || far(&[one.delay_s], &[other.delay_s], LEAST_DELAY_S)
}

/// The sensor's faults for people.
pub(crate) fn in_words(sensing: &Sensing) -> String {
    let [roll_deg, pitch_deg, yaw_deg] = sensing.misalignment_deg;
    let [x_dps, y_dps, z_dps] = sensing.bias_dps;
    format!(
        "mounted at roll {roll_deg:.2}°, pitch {pitch_deg:.2}°, yaw {yaw_deg:.2}°; gyroscope's bias \
         {x_dps:.2}, {y_dps:.2}, {z_dps:.2} °/s, scale {:.4}; {:.0} ms late",
        sensing.scale,
        1000.0 * sensing.delay_s
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::explainer::tests::{faulty_sensor, nothing_unusual};

    fn tilted_sensor(roll_deg: f64) -> WalkExplanation {
        faulty_sensor("imu_misalignment", &[("roll_deg", roll_deg)])
    }

    #[test]
    fn what_is_found_adds_to_what_was_corrected_already() {
        let corrected = Sensing {
            misalignment_deg: [1.0, -0.5, 0.0],
            scale: 1.02,
            ..Sensing::default()
        };
        let better = known_better(corrected, &tilted_sensor(2.0)).unwrap();
        assert_eq!(better.misalignment_deg, [3.0, -0.5, 0.0]);
        assert_eq!(better.scale, corrected.scale);
        assert_eq!(known_better(corrected, &tilted_sensor(0.1)), None);
        assert_eq!(known_better(corrected, &nothing_unusual()), None);
        assert!(in_words(&better).starts_with("mounted at roll 3.00°, pitch -0.50°, yaw 0.00°"));
    }

    #[test]
    fn a_recording_and_one_moment_of_it_are_corrected_alike() {
        let sensing = Sensing {
            misalignment_deg: [2.0, -1.0, 0.0],
            bias_dps: [0.5, 0.0, 3.0],
            scale: 1.1,
            delay_s: 0.02,
            ..Sensing::default()
        };
        // At rest, tilted as it is mounted; it reports its bias.
        let shown_rad = Axes {
            roll: 2.0_f64.to_radians(),
            pitch: -1.0_f64.to_radians(),
            yaw: 0.0,
        };
        let times_s: Vec<f64> = (0..10).map(|i| f64::from(i) * 0.01).collect();
        let on_body = UnitQuaternion::from_euler_angles(shown_rad.roll, shown_rad.pitch, 0.0);
        let up = Vector3::z() * 9.81;
        let raw = RawSeries {
            times_s: times_s.clone(),
            accelerations_mps2: vec![on_body.inverse() * up; 10],
            angular_rates_radps: vec![Vector3::z() * 3.0_f64.to_radians(); 10],
        };
        let angles = shown_rad.map(|_, angle| vec![angle; 10]);
        let orientation = mlr_filter::OrientationSeries::new(times_s, angles).unwrap();
        let recording = Recording {
            raw: Some(raw),
            ..Recording::from(orientation)
        };
        let body = corrected(recording, &sensing);
        let raw = body.raw.unwrap();
        assert_eq!(raw.times_s, body.orientation.times_s());
        assert!((raw.times_s[0] + 0.02).abs() < 1e-12);
        assert!((raw.accelerations_mps2[5] - up).norm() < 1e-9);
        assert!(raw.angular_rates_radps[5].norm() < 1e-9);
        let moment = corrected_tilt(shown_rad, &sensing);
        let angles = body.orientation.angles_rad();
        assert!((angles.roll[5] - moment.roll).abs() < 1e-12 && moment.roll.abs() < 1e-12);
        assert!((angles.pitch[5] - moment.pitch).abs() < 1e-12 && moment.pitch.abs() < 1e-12);
        // A swing is as large as it is, whatever the gyroscope makes of it.
        let swing = Axes {
            roll: shown_rad.roll + 0.1,
            ..shown_rad
        };
        assert!((corrected_tilt(swing, &sensing).roll - 0.11).abs() < 1e-12);
    }

    #[test]
    fn a_bias_that_stays_in_the_recordings_is_not_added_up() {
        let explanation = faulty_sensor(
            "gyro_bias",
            &[("x_dps", 2.0), ("y_dps", 0.0), ("z_dps", 1.0)],
        );
        let once = known_better(Sensing::default(), &explanation).unwrap();
        assert_eq!(once.bias_dps, [2.0, 0.0, 1.0]);
        let twice = known_better(once, &explanation).unwrap();
        assert_eq!(twice.bias_dps, [2.0, 0.0, 2.0]);
        let about_x = faulty_sensor("gyro_bias", &[("x_dps", 2.05)]);
        assert_eq!(known_better(once, &about_x), None);
    }

    #[test]
    fn what_makes_no_difference_is_not_kept() {
        let small = Sensing {
            misalignment_deg: [0.19, -0.19, 0.0],
            bias_dps: [0.0, -0.09, 0.09],
            scale: 1.004,
            delay_s: 0.004,
            ..Sensing::default()
        };
        let perfect = Sensing::default();
        assert!(!differs(&perfect, &perfect));
        assert!(!differs(&small, &perfect));
        for found in [
            Sensing {
                misalignment_deg: [0.0, -0.3, 0.0],
                ..small
            },
            Sensing {
                bias_dps: [0.0, 0.0, -0.2],
                ..small
            },
            Sensing {
                scale: 0.99,
                ..small
            },
            Sensing {
                delay_s: 0.02,
                ..small
            },
        ] {
            assert!(differs(&found, &perfect), "{found:?}");
        }
    }
}
