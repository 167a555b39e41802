//! `mlrd`: the onboard daemon.

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    mlrd::run(&mlrd::Options::parse())
}
