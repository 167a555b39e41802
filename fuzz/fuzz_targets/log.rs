#![no_main]

use libfuzzer_sys::fuzz_target;
use mlr_imu::{Columns, LogColumn, LogLimits, LogProblem, LogTable, Recording};

/// Small, so that inputs of a few kilobytes reach them.
const LIMITS: LogLimits = LogLimits {
    max_rows: 200,
    max_bytes: 20_000,
    max_line_bytes: 500,
    max_columns: 20,
    max_unreadable_share: 0.3,
    max_unreadable_run: 3,
};
/// Characters of a message, with room for lists of names that are shortened.
const LONGEST_MESSAGE: usize = 4000;

fuzz_target!(|bytes: &[u8]| {
    let table = LogTable::from_bytes(bytes, None, LIMITS);
    match table.and_then(|table| Recording::from_table(table, &Columns::default())) {
        Ok(recording) => check(&recording),
        Err(problem) => check_message(&problem.to_string()),
    }
    check_columns(bytes);
});

/// No more than the limits allow, and nothing but finite numbers.
fn check(recording: &Recording) {
    let orientation = &recording.orientation;
    let rows = orientation.len();
    assert!(rows > 0 && rows as u64 <= LIMITS.max_rows);
    let angles = orientation.angles_rad();
    for column in [
        orientation.times_s(),
        &angles.roll,
        &angles.pitch,
        &angles.yaw,
    ] {
        assert_eq!(column.len(), rows);
        assert!(column.iter().all(|x| x.is_finite()));
    }
    if let Some(raw) = &recording.raw {
        assert_eq!(raw.times_s, orientation.times_s());
        for vectors in [&raw.accelerations_mps2, &raw.angular_rates_radps] {
            assert_eq!(vectors.len(), rows);
            assert!(vectors.iter().flat_map(|v| v.iter()).all(|x| x.is_finite()));
        }
    }
    recording.notes.iter().for_each(|note| check_message(note));
}

fn check_message(message: &str) {
    assert!(message.chars().count() <= LONGEST_MESSAGE, "{message}");
    assert!(!message.contains("line 0"), "{message}");
}

/// Every column, whatever its name, as times and as numbers.
fn check_columns(bytes: &[u8]) {
    let read = |column: fn(usize, f64) -> LogColumn| -> Result<(), LogProblem> {
        let table = LogTable::from_bytes(bytes, None, LIMITS)?;
        assert!(table.names().len() <= LIMITS.max_columns);
        let wanted: Vec<_> = (0..table.names().len()).map(|i| column(i, 1.0)).collect();
        let values = table.read(&wanted)?;
        assert_eq!(values.columns.len(), wanted.len());
        for column in values.columns {
            assert!(!column.is_empty() && column.len() as u64 <= LIMITS.max_rows);
            assert!(column.iter().all(|x| x.is_finite()));
        }
        Ok(())
    };
    for column in [LogColumn::of_times, LogColumn::of_numbers] {
        if let Err(problem) = read(column) {
            check_message(&problem.to_string());
        }
    }
}
