use mlr_imu::Recording;

use crate::AnswerError;

/// Drops samples with bad time stamps and says so, unless they are more than the
/// given share of all.
pub(crate) fn repair_time_stamps(
    recording: &Recording,
    max_dropped_share: f64,
    warnings: &mut Vec<String>,
) -> Result<Recording, AnswerError> {
    let total = recording.orientation.len();
    let (recording, faults) = recording.clone().with_increasing_times();
    let dropped = faults.dropped();
    if dropped as f64 > max_dropped_share * total as f64 {
        return Err(AnswerError::Disordered {
            dropped,
            total,
            first: faults.first.map_or(0, |index| index + 1),
        });
    }
    if dropped > 0 {
        warnings.push(format!(
            "dropped {dropped} of {total} samples with bad time stamps ({} duplicated, {} out of order)",
            faults.duplicated, faults.out_of_order
        ));
    }
    Ok(recording)
}
