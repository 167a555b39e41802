//! Orientation from a real MPU6050 against the encoder of the shaft it sat on.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::{fs::File, io::BufReader};

use flate2::bufread::GzDecoder;
use mlr_filter::OrientationSeries;
use mlr_golden_tests::{data, shaft_sensor_columns};
use mlr_imu::read_log;

/// The orientation fused from the sensor on the shaft, and the encoder in degrees.
fn fused(file: &str) -> (OrientationSeries, Vec<f64>) {
    let path = data(&format!("real/mpu6050-encoder/{file}"));
    let columns = shaft_sensor_columns();
    let orientation = read_log(&path, &columns).unwrap().orientation;
    let text = GzDecoder::new(BufReader::new(File::open(&path).unwrap()));
    let mut reader = csv::Reader::from_reader(text);
    let column = reader
        .headers()
        .unwrap()
        .iter()
        .position(|name| name == "encoder_deg")
        .unwrap();
    let encoder_deg = reader
        .records()
        .map(|row| row.unwrap()[column].parse().unwrap())
        .collect();
    (orientation, encoder_deg)
}

/// Root mean square of the difference, each taken to the nearest turn, after the
/// median difference is removed.
fn rms_deg(ours_deg: impl Iterator<Item = f64>, encoder_deg: &[f64]) -> f64 {
    let mut differences: Vec<f64> = ours_deg
        .zip(encoder_deg)
        .map(|(ours, encoder)| (ours - encoder).rem_euclid(360.0))
        .collect();
    let reference = differences[0];
    for difference in &mut differences {
        *difference = (*difference - reference + 180.0).rem_euclid(360.0) - 180.0;
    }
    let mut sorted = differences.clone();
    sorted.sort_by(f64::total_cmp);
    let median = sorted[sorted.len() / 2];
    let squares: f64 = differences.iter().map(|d| (d - median).powi(2)).sum();
    (squares / differences.len() as f64).sqrt()
}

#[test]
fn roll_follows_the_encoder() {
    let (orientation, encoder_deg) = fused("roll.csv.gz");
    let roll = orientation.angles_rad().roll.iter();
    let error_deg = rms_deg(roll.map(|angle| angle.to_degrees()), &encoder_deg);
    assert!(error_deg < 1.0, "{error_deg}");
}

#[test]
fn yaw_drifts_as_far_as_a_gyroscope_lets_it() {
    let (orientation, encoder_deg) = fused("yaw.csv.gz");
    let yaw = orientation.angles_rad().yaw.iter();
    let error_deg = rms_deg(yaw.map(|angle| -angle.to_degrees()), &encoder_deg);
    assert!(error_deg < 12.0, "{error_deg}");
}
