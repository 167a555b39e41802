//! Results to stdout or into new files, everything else to stderr.
//!
//! Whatever goes to a terminal passes [`printable`]: names and texts of a file can hold control
//! characters.

use std::{
    io::{self, Write},
    path::Path,
};

use anyhow::{Context, bail};
use mlr_imu::NewFile;

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

/// Characters of a message, which is no longer than a screen.
const MAX_MESSAGE: usize = 2000;
/// Characters of one line of a message: a line of a file that is quoted leaves room for what is
/// wrong with it.
const MAX_LINE: usize = 500;

/// A new text file that a result goes to.
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

    pub(super) fn write(self, text: &str) -> anyhow::Result<()> {
        self.file
            .write(|file| file.write_all(text.as_bytes()))
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

/// What stands for stdout as the name of a file.
pub(super) const STDOUT: &str = "-";

/// Lets a write beyond the size that the system allows a file fail, with a message and nothing
/// left behind, where the signal that comes with it would end the program at once.
#[cfg(unix)]
pub(super) fn outlive_file_size_limits() -> io::Result<()> {
    // Nobody asks the flag: that the signal is handled is enough.
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

/// The text without control characters other than line feeds, and without characters that are
/// invisible or turn the direction of writing. They appear as in JSON, so that JSON means the
/// same as before.
fn printable(text: &str) -> String {
    let mut clean = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '\n' | ' '..='~' => clean.push(character),
            '\t' => clean.push(' '),
            // What Rust does not escape is a visible character that stands for itself.
            _ if character.escape_debug().len() == 1 => clean.push(character),
            _ => {
                for unit in character.encode_utf16(&mut [0; 2]) {
                    clean += &format!("\\u{unit:04x}");
                }
            }
        }
    }
    clean
}

/// The text as far as it fits on a screen, printable.
fn of_a_screen(text: &str) -> String {
    let text = printable(text);
    let lines: Vec<String> = text.lines().map(|line| shortened(line, MAX_LINE)).collect();
    shortened(&lines.join("\n"), MAX_MESSAGE)
}

fn shortened(text: &str, most: usize) -> String {
    match text.char_indices().nth(most) {
        None => text.into(),
        Some((end, _)) => {
            let (shown, rest) = text.split_at(end);
            format!("{shown}… ({} more)", rest.chars().count())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_invisible_reaches_the_terminal() {
        let hostile =
            "a\u{1b}[31m\u{7f}\u{9b}\u{202e}b\u{200b}\u{ad}\u{2066}\u{feff}\u{e0041}\r\tc";
        let clean = printable(hostile);
        assert!(
            clean.chars().all(|c| c.is_ascii_graphic() || c == ' '),
            "{clean:?}"
        );
        for usual in ["0.5° ± 2 µs: größer, …", "line 1\nline 2 \"a\\b\" 'c'"] {
            assert_eq!(printable(usual), usual);
        }
    }

    #[test]
    fn json_keeps_its_meaning() {
        let value = serde_json::json!({"log": "\u{202e}\u{1b}\u{e0041}\u{7f}ä\n\"\\"});
        let printed = printable(&value.to_string());
        assert!(printed.contains("\\u202e"), "{printed}");
        let read: serde_json::Value = serde_json::from_str(&printed).unwrap();
        assert_eq!(read, value);
    }

    #[test]
    fn a_message_fits_on_a_screen() {
        let quoted = format!("line 1\n{}\nexpected a number", "ä".repeat(1_000_000));
        let message = of_a_screen(&quoted);
        assert!(message.chars().count() < 600, "{}", message.len());
        assert!(message.contains("(999500 more)") && message.ends_with("expected a number"));
        let long = of_a_screen(&"line\n".repeat(10_000));
        assert!(long.chars().count() < 2100);
        assert_eq!(of_a_screen("short"), "short");
    }
}
