//! Results to stdout or into new files, everything else to stderr.
//!
//! Whatever goes to a terminal passes [`printable()`]: names and texts of a file can hold control
//! characters. The only ones beside line feeds are those of [`LABEL`], where the terminal shows colours
//! and `NO_COLOR` is not set.

use std::{
    borrow::Cow,
    io::{self, Write},
    path::Path,
};

use anstream::AutoStream;
use anstyle::{AnsiColor, Style};
use anyhow::{Context, bail};
use log::{Level, LevelFilter, Log, Metadata, Record};
use mlr_filter::SettingError;
use mlr_imu::{NewFile, of_a_screen, printable};

/// How a label looks.
const LABEL: Style = AnsiColor::Cyan.on_default();
const ERROR: Style = AnsiColor::Red.on_default().bold();
const WARNING: Style = AnsiColor::Yellow.on_default().bold();

/// A result for people: labels on the left, text on the right.
#[derive(Debug, Default)]
pub(super) struct Table(String);

impl Table {
    /// Adds a line. An empty label continues the one above.
    pub(super) fn line(&mut self, label: &str, text: impl std::fmt::Display) {
        // A column for colours of their own.
        let text = printable(&text.to_string());
        self.0 += &match label {
            "" => format!("{:14}{text}\n", ""),
            _ => format!("{LABEL}{label:<14}{LABEL:#}{text}\n"),
        };
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

/// The error of a setting that an option of its name sets, as in `--walk-s` for `walk_s`.
pub(super) fn under_its_option(error: SettingError) -> SettingError {
    SettingError {
        name: format!("--{}", error.name.replace('_', "-")),
        ..error
    }
}

/// Prints a finished result on stdout, all at once.
pub(super) fn result(text: &str) -> io::Result<()> {
    let (on, off) = (LABEL.render().to_string(), LABEL.render_reset().to_string());
    let between = |text: &str, style: &str, clean: &dyn Fn(&str) -> String| {
        text.split(style).map(clean).collect::<Vec<_>>().join(style)
    };
    let clean = between(text, &on, &|part| between(part, &off, &printable));
    let mut stdout = AutoStream::auto(io::stdout().lock());
    stdout.write_all(clean.as_bytes())?;
    stdout.flush()
}

/// Says on stderr what is logged, as long as it is important enough.
pub(super) fn say_up_to(level: LevelFilter) {
    // Refused where another one is there already: then that one says it.
    if log::set_logger(&Stderr).is_ok() {
        log::set_max_level(level);
    }
}

/// Whether notes and progress are wanted.
pub(super) fn is_quiet() -> bool {
    log::max_level() == LevelFilter::Error
}

struct Stderr;

impl Log for Stderr {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.target().starts_with("mlr")
    }

    /// When this fails there is nobody left to tell.
    fn log(&self, record: &Record<'_>) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let (style, kind) = match record.level() {
            Level::Error => (ERROR, ""),
            Level::Warn => (WARNING, "warning: "),
            _ => (Style::new(), ""),
        };
        let text = of_a_screen(&record.args().to_string());
        let mut stderr = AutoStream::auto(io::stderr().lock());
        let _ = writeln!(stderr, "{style}mlr-ga: {kind}{style:#}{text}");
    }

    fn flush(&self) {}
}

/// Says what went wrong on stderr.
pub(super) fn error(error: &anyhow::Error) {
    log::error!("{error:#}");
}

/// Warns on stderr, unless told to be quiet.
pub(super) fn warning(text: &str) {
    log::warn!("{text}");
}

/// Says something on stderr, unless told to be quiet.
pub(super) fn message(text: &str) {
    log::info!("{text}");
}
