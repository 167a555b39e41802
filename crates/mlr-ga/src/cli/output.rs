//! Results to stdout, everything else to stderr.

use std::io::{self, Write};

/// Prints a finished result on stdout, all at once.
pub(super) fn result(text: &str) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    stdout.write_all(text.as_bytes())?;
    stdout.flush()
}

/// Says what went wrong on stderr. When even that fails there is nobody left to
/// tell.
pub(super) fn error(error: &anyhow::Error) {
    let _ = writeln!(io::stderr().lock(), "mlr-ga: {error:#}");
}

/// Warns on stderr.
pub(super) fn warning(text: &str) {
    let _ = writeln!(io::stderr().lock(), "mlr-ga: warning: {text}");
}
