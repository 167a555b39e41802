//! The one place where errors become exit statuses.

use std::{io, process::ExitCode};

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
    let cannot_answer = error.chain().any(mlr_ga::says_log_cannot_answer);
    ExitCode::from(if cannot_answer {
        CANNOT_ANSWER
    } else {
        BAD_INPUT
    })
}
