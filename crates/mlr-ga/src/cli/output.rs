//! Results to stdout or into new files, everything else to stderr.
//!
//! Whatever goes to a terminal passes [`printable()`]: names and texts of a file can hold control
//! characters.

use std::{
    borrow::Cow,
    io::{self, Write},
    path::Path,
};

use anyhow::{Context, bail};
use mlr_imu::{NewFile, of_a_screen, printable};

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

/// A new file that a result goes to.
#[derive(Debug)]
pub(super) struct ResultFile {
    name: String,
    file: NewFile,
}

impl ResultFile {
    /// Makes sure that it can be written before the work begins.
    pub(super) fn reserve(path: &Path) -> anyhow::Result<Self> {
        refuse_stdout(path)?;
        let name = path.display().to_string();
        let file = NewFile::reserve(path).with_context(|| name.clone())?;
        Ok(Self { name, file })
    }

    pub(super) fn write(self, content: impl AsRef<[u8]>) -> anyhow::Result<()> {
        self.file
            .write(|file| file.write_all(content.as_ref()))
            .context(self.name)?;
        Ok(())
    }
}

/// Refuses `-` as the name of a file that cannot go to stdout.
pub(super) fn refuse_stdout(path: &Path) -> anyhow::Result<()> {
    if path.as_os_str() == STDOUT {
        bail!(
            "-: only logs can be written to stdout, expected the name of a file (for one called -, ./-)"
        );
    }
    Ok(())
}

/// The last part of a path, for tables and pictures; all of it where there is none.
pub(super) fn file_name(path: &str) -> Cow<'_, str> {
    let name = Path::new(path).file_name();
    name.map_or(Cow::Borrowed(path), |name| name.to_string_lossy())
}

/// What stands for stdout as the name of a file.
pub(super) const STDOUT: &str = "-";

/// Lets a write beyond the size that the system allows a file fail, with a message and nothing
/// left behind, where the signal that comes with it would end the program at once.
#[cfg(unix)]
pub(super) fn outlive_file_size_limits() -> io::Result<()> {
    // The flag is never read: that the signal is handled is enough.
    let unread = std::sync::Arc::default();
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, unread)?;
    Ok(())
}

#[cfg(not(unix))]
pub(super) fn outlive_file_size_limits() -> io::Result<()> {
    Ok(())
}

/// Prints a finished result on stdout, all at once.
pub(super) fn result(text: &str) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    stdout.write_all(printable(text).as_bytes())?;
    stdout.flush()
}

/// Says what went wrong on stderr. When even that fails there is nobody left to
/// tell.
pub(super) fn error(error: &anyhow::Error) {
    message(&format!("{error:#}"));
}

/// Warns on stderr.
pub(super) fn warning(text: &str) {
    message(&format!("warning: {text}"));
}

/// Says something on stderr.
pub(super) fn message(text: &str) {
    let _ = writeln!(io::stderr().lock(), "mlr-ga: {}", of_a_screen(text));
}
