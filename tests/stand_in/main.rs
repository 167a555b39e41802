//! Detection, identification and explanation of the stand-in logs, as they are and spoilt, with
//! default settings but for fewer variations of the model. The truth is read by the assertions
//! only. One program, because all share an atlas that takes minutes to simulate.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod bad_logs;
mod detection;
mod explanation;
mod identification;
mod model;
mod truth;

use mlr_filter::OrientationSeries;
use mlr_golden_tests::data;
use mlr_imu::{Columns, Recording, read_log};

fn recording(name: &str) -> Recording {
    recording_of(name, &Columns::default())
}

fn recording_of(name: &str, columns: &Columns) -> Recording {
    read_log(data(&format!("logs/stand-in/{name}.csv.gz")), columns).unwrap()
}

/// Looks for the orientation under names that no log has.
fn only_raw_columns() -> Columns {
    let mut columns = Columns::default();
    for axis in ["roll", "pitch", "yaw"] {
        columns.rename(&format!("{axis}=not_there")).unwrap();
    }
    columns
}

/// What is recorded from this time on.
fn from_s(recording: &OrientationSeries, from_s: f64) -> OrientationSeries {
    let from = recording.times_s().partition_point(|&t| t < from_s);
    OrientationSeries::new(
        recording.times_s()[from..].to_vec(),
        recording
            .angles_rad()
            .as_ref()
            .map(|_, samples| samples[from..].to_vec()),
    )
    .unwrap()
}
