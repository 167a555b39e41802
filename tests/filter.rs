//! The filter against SciPy (`tools/golden/filter.py`).
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use mlr_filter::{FilterSettings, FourierFilter, SamplingLimits, Window};
use mlr_golden_tests::{angles, data};
use mlr_imu::{Columns, read_log};

/// Everything from the log file to the reconstructed signal.
fn agrees_with_scipy(log: &str, start_s: f64, duration_s: f64, golden: &str) {
    let recording = read_log(data(log), &Columns::default())
        .unwrap()
        .orientation;
    let window = Window {
        start_s,
        duration_s,
    };
    let cut = window.cut(&recording, &SamplingLimits::default()).unwrap();
    let conditioned = FourierFilter::new(FilterSettings::default(), duration_s)
        .unwrap()
        .condition(&cut);
    let expected = angles(golden);
    for (ours, scipy) in [
        (&conditioned.roll, &expected.roll),
        (&conditioned.pitch, &expected.pitch),
        (&conditioned.yaw, &expected.yaw),
    ] {
        assert_eq!(ours.len(), scipy.len());
        assert!(
            scipy.iter().any(|x| x.abs() > 1e-3),
            "the golden signal is not empty"
        );
        for (a, b) in ours.iter().zip(scipy) {
            assert!((a - b).abs() < 1e-9, "{a} against SciPy's {b}");
        }
    }
}

#[test]
fn synthetic_signals() {
    agrees_with_scipy(
        "golden/filter/synthetic.csv.gz",
        0.5,
        5.0,
        "golden/filter/synthetic-start0.5-duration5.csv.gz",
    );
}

#[test]
fn a_stand_in_log() {
    agrees_with_scipy(
        "logs/stand-in/legs1-4-lost.csv.gz",
        2.22,
        5.0,
        "golden/filter/legs1-4-lost-start2.22-duration5.csv.gz",
    );
}

#[test]
fn a_short_window() {
    agrees_with_scipy(
        "logs/stand-in/legs1-4-lost.csv.gz",
        4.0,
        2.0,
        "golden/filter/legs1-4-lost-start4-duration2.csv.gz",
    );
}
