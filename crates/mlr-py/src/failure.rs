//! Errors of the library as exceptions: the two exit statuses of the command line as two classes.

use pyo3::{PyErr, import_exception};

import_exception!(mlr.errors, BadInput);
import_exception!(mlr.errors, CannotAnswer);

/// The exception of an error, with the error's message and those of its causes.
pub(crate) fn exception(error: &anyhow::Error) -> PyErr {
    let message = format!("{error:#}").trim_end().to_string();
    match error.chain().any(mlr_ga::says_log_cannot_answer) {
        true => CannotAnswer::new_err(message),
        false => BadInput::new_err(message),
    }
}

/// Names a log in an error if that is the log's fault, and it has a name.
pub(crate) fn blame<E>(error: E, log: Option<&String>) -> anyhow::Error
where
    E: std::error::Error + Send + Sync + 'static,
{
    let of_the_log = mlr_ga::says_log_cannot_answer(&error);
    let error = anyhow::Error::from(error);
    match log.filter(|log| of_the_log && !log.is_empty()) {
        Some(log) => error.context(log.clone()),
        None => error,
    }
}
