//! The one place where errors become exit statuses.

use std::{io, process::ExitCode};

use mlr_ga::{AnswerError, CalibrateError, ExplainError, UnfitRobot};
use mlr_residual::{SensorError, servo::ServoError};

/// The log was read and cannot answer.
const CANNOT_ANSWER: u8 = 1;
/// Wrong usage or unreadable input; clap uses the same for wrong arguments.
const BAD_INPUT: u8 = 2;

/// Prints an error with its causes on stderr and chooses the exit status.
pub(super) fn exit_status(result: anyhow::Result<()>) -> ExitCode {
    let Err(error) = result else {
        return ExitCode::SUCCESS;
    };
    // Whoever read our output has seen enough of it.
    if error
        .chain()
        .filter_map(|cause| cause.downcast_ref::<io::Error>())
        .any(|cause| cause.kind() == io::ErrorKind::BrokenPipe)
    {
        return ExitCode::SUCCESS;
    }
    super::output::error(&error);
    let cannot_answer = error.chain().any(|cause| {
        cause.is::<UnfitRobot>()
            || cause
                .downcast_ref::<AnswerError>()
                .is_some_and(AnswerError::is_recordings_fault)
            || cause
                .downcast_ref::<ExplainError>()
                .is_some_and(ExplainError::is_recordings_fault)
            || cause
                .downcast_ref::<CalibrateError>()
                .is_some_and(CalibrateError::is_recordings_fault)
            || cause
                .downcast_ref::<SensorError>()
                .is_some_and(SensorError::is_recordings_fault)
            || cause
                .downcast_ref::<ServoError>()
                .is_some_and(ServoError::is_recordings_fault)
    });
    ExitCode::from(if cannot_answer {
        CANNOT_ANSWER
    } else {
        BAD_INPUT
    })
}
