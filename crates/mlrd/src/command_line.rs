use std::process::ExitCode;

use clap::{Parser, Subcommand};

#[cfg(feature = "top")]
use crate::top::{TopOptions, top};
use crate::{
    Options,
    check::{CheckOptions, check},
    service,
};

/// The daemon's command line.
#[derive(Debug, Parser)]
#[command(
    name = "mlrd",
    version = env!("MLR_VERSION"),
    about = "Reads an IMU, notices when the robot is damaged, and identifies it",
    long_about = None,
    max_term_width = 100,
    args_conflicts_with_subcommands = true
)]
pub struct CommandLine {
    #[command(flatten)]
    options: Options,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    Check(Box<CheckOptions>),
    #[cfg(feature = "top")]
    Top(TopOptions),
}

impl CommandLine {
    /// Does what is asked for.
    pub fn run(&self) -> ExitCode {
        match &self.command {
            Some(Command::Check(options)) => check(options),
            #[cfg(feature = "top")]
            Some(Command::Top(options)) => top(options),
            None => service::run(&self.options),
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn without_a_command_it_is_the_daemon() {
        CommandLine::command().debug_assert();
        let line = |arguments: &[&str]| {
            CommandLine::try_parse_from(["mlrd"].iter().chain(arguments)).map(|line| line.command)
        };
        assert!(line(&["--port", "/dev/ttyTHS1"]).unwrap().is_none());
        let check = ["check", "--port", "/dev/ttyTHS1", "--json"];
        assert!(line(&check).unwrap().is_some());
        assert!(line(&["--port", "/dev/ttyTHS1", "check"]).is_err());
    }
}
