//! The live view: what the daemon does, on a terminal, from the events that it prints.
//!
//! Lines of the stream become [`Line`]s, a [`Picture`] follows from them, and [`draw`] shows it.

mod drawing;
mod picture;
mod reader;
mod saying;
mod screen;
mod told;

use std::{
    fs::File,
    io::{self, BufRead, BufReader, IsTerminal, Write},
    path::PathBuf,
    process::ExitCode,
};

use anyhow::{Context, bail};
use clap::Args;

pub use drawing::{Palette, View, draw};
pub use picture::Picture;
pub use told::{Line, Told, What};

use crate::{event::WatchedRobot, settings};

/// Shows on a terminal what the daemon does, from the events that it prints; where stdout is no
/// terminal, each event as a line of text.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  mlrd --port /dev/ttyTHS1 2>&1 | mlrd top
  ssh robot journalctl -u mlrd -n 1000 -f -o cat | mlrd top
  mlrd top events.jsonl")]
pub(crate) struct TopOptions {
    /// Events, one on each line, as mlrd prints them [default: standard input].
    file: Option<PathBuf>,
    /// The robot that is drawn until the events tell which one is watched [default: the embedded
    /// JetHexa].
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
}

/// Shows events until their end where stdout is no terminal, or until it is told to leave. The
/// exit status is 2 where there is nothing to read.
pub(crate) fn top(options: &TopOptions) -> ExitCode {
    match show(options) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // Nobody is left to be told where stderr is closed.
            let _ = writeln!(io::stderr(), "error: {error:#}");
            ExitCode::from(2)
        }
    }
}

fn show(options: &TopOptions) -> anyhow::Result<()> {
    let (_, robot) = settings::robot(options.robot.as_deref())?;
    let picture = Picture::new(WatchedRobot::new(&robot));
    let (name, stream): (String, Box<dyn BufRead + Send>) = match &options.file {
        Some(path) => {
            let name = path.display().to_string();
            if path.is_dir() {
                bail!(
                    "{name}: is a folder, expected a file of events as mlrd prints them; \
                     recordings hold samples and no events"
                );
            }
            let file = File::open(path).with_context(|| name.clone())?;
            (name, Box::new(BufReader::new(file)))
        }
        None if io::stdin().is_terminal() => bail!(
            "no events: expected them on standard input, as in mlrd --port /dev/ttyTHS1 2>&1 | mlrd top, \
             or a file of them"
        ),
        None => ("stdin".into(), Box::new(BufReader::new(io::stdin()))),
    };
    if io::stdout().is_terminal() {
        let palette = Palette::of_no_color(std::env::var_os("NO_COLOR").as_deref());
        return screen::show(stream, picture, palette);
    }
    print(stream, picture).with_context(|| name)
}

/// Prints each line of the stream in words. A reader who has seen enough is no failure.
fn print(mut stream: impl BufRead, mut picture: Picture) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    while let Some(line) = reader::next_line(&mut stream)? {
        let said = picture.apply(&line);
        match writeln!(stdout, "{said}") {
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => return Ok(()),
            printed => printed?,
        }
    }
    Ok(())
}
