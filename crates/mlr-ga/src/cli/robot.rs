//! `mlr-ga robot check`.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, Subcommand};
use mlr_ga::{RobotCheck, check_robot};
use mlr_imu::{MAX_TEXT_BYTES, read_text};
use mlr_model::{Gait, Robot};

use super::{
    output::{self, ResultFile, Table},
    robot_drawing,
};

#[derive(Debug, Args)]
pub(super) struct RobotOptions {
    #[command(subcommand)]
    command: RobotCommand,
}

#[derive(Debug, Subcommand)]
enum RobotCommand {
    /// Checks that a description makes a robot whose feet reach the ground, that stands and walks.
    ///
    /// Exit status 0: it can be used, whatever doubts are listed. 1: it cannot. 2: a file cannot be
    /// read.
    Check(CheckOptions),
}

#[derive(Debug, Args)]
struct CheckOptions {
    /// The description in TOML.
    #[arg(value_name = "FILE")]
    robot: PathBuf,
    /// Its gait in TOML [default: the embedded tripod, which has six legs].
    #[arg(long, value_name = "FILE")]
    gait: Option<PathBuf>,
    /// Draw the robot into this folder: above.svg, side.svg, leg1.svg with the angles of a leg, and
    /// phases.svg. An existing file is never overwritten.
    #[arg(long, value_name = "DIR")]
    svg: Option<PathBuf>,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(options: &RobotOptions) -> anyhow::Result<()> {
    let RobotCommand::Check(options) = &options.command;
    let robot = read(&options.robot, MAX_TEXT_BYTES, Robot::from_toml)?;
    let gait = match &options.gait {
        Some(path) => read(path, Gait::MOST_FILE_BYTES, Gait::from_toml)?,
        None => Gait::tripod(),
    };
    let check = check_robot(&robot, &gait)?;
    if let Some(folder) = &options.svg {
        draw(folder, &robot, &gait)?;
    }
    let text = match options.json {
        true => serde_json::to_string(&check)? + "\n",
        false => table(&check),
    };
    output::result(&text)?;
    Ok(check.verdict()?)
}

fn read<T, E: std::error::Error + Send + Sync + 'static>(
    path: &Path,
    most_bytes: u64,
    parse: impl FnOnce(&str) -> Result<T, E>,
) -> anyhow::Result<T> {
    let name = || path.display().to_string();
    let text = read_text(path, most_bytes).with_context(name)?;
    parse(&text).with_context(name)
}

fn draw(folder: &Path, robot: &Robot, gait: &Gait) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    for (name, drawn) in robot_drawing::all(robot, gait)? {
        ResultFile::reserve(&folder.join(name))?.write(&drawn)?;
    }
    Ok(())
}

/// What was found, for people.
fn table(check: &RobotCheck) -> String {
    let mut table = Table::default();
    table.line("robot", &check.robot);
    table.line("gait", &check.gait);
    table.line(
        "parts",
        format!(
            "{} legs, {} joints, {:.2} kg",
            check.legs, check.joints, check.mass_kg
        ),
    );
    if let Some(margin_m) = check.stance_margin_m {
        let tilt = check.standing_tilt_deg;
        let tilt = tilt.map_or(String::new(), |tilt_deg| {
            format!(", leaning by {tilt_deg:.1}°")
        });
        table.line(
            "stance",
            format!(
                "centre of mass {:.0} mm inside the feet{tilt}",
                1e3 * margin_m
            ),
        );
    }
    if let Some(walking) = &check.walking {
        let told = check.commanded_speed_m_per_s;
        let told = told.map_or(String::new(), |told| format!(" of {:.0}", 1e3 * told));
        table.line(
            "walk",
            format!(
                "{:.0}{told} mm/s, tilt up to {:.1}°, fluctuation {:.1}°, torque up to {:.0} %",
                1e3 * walking.speed_m_per_s,
                walking.tilt_deg,
                walking.fluctuation_deg,
                100.0 * walking.torque_share
            ),
        );
    }
    table.lines("doubt", check.doubts.iter().cloned());
    table.lines("problem", check.problems.iter().cloned());
    table.line(
        "verdict",
        match check.problems.is_empty() {
            true => "stands and walks",
            false => "cannot be used",
        },
    );
    table.into_text()
}
