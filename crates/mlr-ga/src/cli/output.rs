//! Results to stdout, everything else to stderr.

use std::io::{self, Write};

/// A result for people: labels on the left, text on the right.
#[derive(Debug, Default)]
pub(super) struct Table(String);

impl Table {
    /// Adds a line. An empty label continues the one above.
    pub(super) fn line(&mut self, label: &str, text: impl std::fmt::Display) {
        self.0 += &format!("{label:<14}{text}\n");
    }

    /// Adds a line for each text, labelled at the first.
    pub(super) fn lines(&mut self, label: &str, texts: impl Iterator<Item = String>) {
        for (index, text) in texts.enumerate() {
            self.line(if index == 0 { label } else { "" }, text);
        }
    }

    /// The finished text.
    pub(super) fn into_text(self) -> String {
        self.0
    }
}

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
