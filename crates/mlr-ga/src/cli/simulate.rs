//! `mlr-ga simulate`.

use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use mlr_ga::{LARGEST_SEED, LogSimulation, SimulateError, SimulationReport};
use mlr_imu::{write_log, write_log_to};
use mlr_model::{GroundContact, JointTrajectory};

use super::{
    model_files::ModelFiles,
    morphology_choice::{LossName, MorphologyChoice},
    output::{self, ResultFile, under_its_option},
};

#[derive(Debug, Args)]
pub(super) struct SimulateOptions {
    /// The log to write: .csv or .csv.gz. An existing file is never overwritten. - writes CSV to
    /// stdout, in place of the sentence or the JSON object.
    #[arg(short, long, value_name = "LOG")]
    output: PathBuf,
    /// Also write the joint angles that the robot was commanded while it walked, as CSV: one row
    /// for each command of its servos (20 ms on the JetHexa), from the stance at 0 s on. A first
    /// line "# repeat A..B" names the rows, from 0, that repeat the gait, where the file shows a
    /// whole cycle of it. An existing file is never overwritten.
    #[arg(long, value_name = "FILE")]
    joints: Option<PathBuf>,
    #[command(flatten)]
    morphology: MorphologyChoice,
    /// What became of lost links.
    #[arg(long, value_enum, default_value_t = LossName::Absent)]
    lost_links: LossName,
    /// How long the robot stands first.
    #[arg(
        long,
        value_name = "SECONDS",
        default_value_t = 2.0,
        allow_negative_numbers = true
    )]
    stand_s: f64,
    /// How long it then walks.
    #[arg(
        long,
        value_name = "SECONDS",
        default_value_t = 10.0,
        allow_negative_numbers = true
    )]
    walk_s: f64,
    /// Time between two samples, and of a simulation step.
    #[arg(
        long,
        value_name = "SECONDS",
        default_value_t = 0.002,
        allow_negative_numbers = true
    )]
    time_step_s: f64,
    /// Friction between feet and ground.
    #[arg(long, value_name = "MU", default_value_t = GroundContact::default().friction, allow_negative_numbers = true)]
    friction: f64,
    /// Dry friction in every joint beyond the described one.
    #[arg(
        long,
        value_name = "NEWTON_METRES",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    joint_friction_nm: f64,
    /// Play in every joint beyond the described one: it is free over this angle.
    #[arg(
        long,
        value_name = "RADIANS",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    backlash_rad: f64,
    /// Inclination of the ground.
    #[arg(
        long,
        value_name = "DEGREES",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    slope_deg: f64,
    /// Direction in which the ground rises, counter-clockwise from straight ahead.
    #[arg(
        long,
        value_name = "DEGREES",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    uphill_deg: f64,
    /// Cover the ground with rubble of this height.
    #[arg(long, value_name = "METRES", allow_negative_numbers = true)]
    rubble_m: Option<f64>,
    /// Chooses the rubble.
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true,
          value_parser = clap::value_parser!(u64).range(..=LARGEST_SEED))]
    seed: u64,
    /// Print one JSON object instead of a sentence.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    model: ModelFiles,
}

pub(super) fn run(options: &SimulateOptions) -> anyhow::Result<()> {
    let simulation = options.simulation();
    simulation.check().map_err(under_its_option)?;
    let (robot, gait) = options.model.read()?;
    let robot = simulation.robot(robot)?;
    let morphology = options.morphology.of(&robot.layout())?;
    let joints = match &options.joints {
        Some(path) => {
            let file = ResultFile::reserve(path)?;
            let joints = JointTrajectory::commanded(&robot, &gait, simulation.walk_s)
                .and_then(|joints| joints.to_csv(&robot))
                .with_context(|| path.display().to_string())?;
            Some((file, joints))
        }
        None => None,
    };
    let log = simulation.log(&robot, &gait, &morphology);
    let log = log.map_err(|error| match error {
        SimulateError::Setting(error) => under_its_option(error).into(),
        error => error,
    })?;
    let to_stdout = options.output.as_os_str() == output::STDOUT;
    if !to_stdout {
        write_log(&options.output, &log)?;
    }
    if let Some((file, joints)) = joints {
        file.write(&joints)?;
    }
    if to_stdout {
        let mut text = Vec::new();
        write_log_to(&mut text, &log)?;
        return Ok(output::result(&String::from_utf8(text)?)?);
    }
    let mut report = SimulationReport::new(&simulation, &morphology, &log);
    report.log = options.output.display().to_string();
    let joints = options.joints.as_ref();
    report.joints = joints.map(|path| path.display().to_string());
    let text = match options.json {
        true => serde_json::to_string(&report)? + "\n",
        false => sentence(&report),
    };
    Ok(output::result(&text)?)
}

/// The report for people.
fn sentence(report: &SimulationReport) -> String {
    format!(
        "{}: {} samples, {}, walking from {} s on\n",
        report.log,
        report.samples,
        report.morphology.describe(),
        report.motion_start_s
    )
}

impl SimulateOptions {
    fn simulation(&self) -> LogSimulation {
        LogSimulation {
            lost_links: self.lost_links.into(),
            stand_s: self.stand_s,
            walk_s: self.walk_s,
            time_step_s: self.time_step_s,
            friction: self.friction,
            joint_friction_nm: self.joint_friction_nm,
            backlash_rad: self.backlash_rad,
            slope_deg: self.slope_deg,
            uphill_deg: self.uphill_deg,
            rubble_m: self.rubble_m,
            seed: self.seed,
        }
    }
}
