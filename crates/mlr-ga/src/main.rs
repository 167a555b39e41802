//! `mlr-ga`: the damaged legs of a robot from a log of its IMU.

mod cli;

fn main() -> std::process::ExitCode {
    cli::run()
}
