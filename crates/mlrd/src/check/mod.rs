//! The doctor: whether the daemon would do its work here, one thing after the other, each with
//! its cure.

mod computer;
mod files;
mod findings;
mod listening;
mod port;
mod sensor;

use std::{
    io::{self, IsTerminal, Write},
    process::ExitCode,
    time::Duration,
};

use clap::Args;

use self::findings::Findings;
use crate::{Options, Settings};

/// Checks settings, files, port, sensor and computer, and says what to do about what is wrong.
#[derive(Debug, Clone, Args)]
pub(crate) struct CheckOptions {
    #[command(flatten)]
    options: Options,
    /// How long the sensor is listened to.
    #[arg(long, value_name = "SECONDS", default_value_t = 3,
          value_parser = clap::value_parser!(u16).range(3..=3600))]
    listen_s: u16,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Checks everything that the daemon needs. The exit status is 0 where nothing failed, 1 where
/// something did, 2 where the options make no sense.
pub(crate) fn check(options: &CheckOptions) -> ExitCode {
    let mut findings = Findings::new(!options.json);
    let settings = match options.options.of_the_file() {
        Ok(settings) => settings,
        Err(error) => {
            let cure = "correct the file; everything else depends on it and is not checked yet";
            findings.failed("settings", format!("{error:#}"), cure);
            return findings.finish();
        }
    };
    let settings = match options.options.in_place_of(settings) {
        Ok(settings) => settings,
        Err(error) => {
            // Nobody is left to be told where stderr is closed.
            let _ = writeln!(io::stderr(), "error: {error:#}");
            return ExitCode::from(2);
        }
    };
    findings.ok(
        "settings",
        match options.options.config() {
            Some(path) => format!("{} and options", path.display()),
            None => "options and defaults".into(),
        },
    );
    check_all(&settings, options, &mut findings);
    findings.finish()
}

fn check_all(settings: &Settings, options: &CheckOptions, findings: &mut Findings) {
    let model = files::model(settings, findings);
    files::state(settings, findings);
    if let Some((robot, gait)) = &model {
        files::calibration(settings, robot, findings);
        files::atlas(settings, robot, gait, findings);
    }
    files::recordings(settings, findings);
    if let Some(mut port) = port::open(settings, findings) {
        let time = Duration::from_secs(options.listen_s.into());
        progress(&format!("listening for {} s", time.as_secs()));
        let heard = listening::listen(&mut *port, settings, time);
        // Other speeds are tried on the same port.
        drop(port);
        sensor::judge(settings, &heard, findings);
    }
    if let Some((robot, gait)) = &model {
        progress("measuring the speed of this computer for 2 s");
        computer::measure(settings, robot, gait, findings);
    }
}

/// Shows on a terminal which step is running.
fn progress(what: &str) {
    if io::stderr().is_terminal() {
        // Whoever closed stderr does not wait for this.
        let _ = writeln!(io::stderr(), "{what} …");
    }
}
