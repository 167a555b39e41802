//! `mlrd`: the onboard daemon.

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    mlrd::CommandLine::parse().run()
}
