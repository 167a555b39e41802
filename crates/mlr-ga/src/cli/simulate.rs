//! `mlr-ga simulate`.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use mlr_filter::{OrientationSeries, SettingError};
use mlr_ga::LARGEST_SEED;
use mlr_imu::{write_log, write_log_to};
use mlr_model::{
    GroundContact, JointTrajectory, ModelError, Morphology, Outcome, Robot, Roughness,
    SimulationSettings, Simulator, Terrain,
};
use schemars::JsonSchema;
use serde::Serialize;

use super::{
    model_files::ModelFiles,
    morphology_choice::{LossName, MorphologyChoice},
    output::{self, ResultFile},
};

/// Version of the JSON output.
const SCHEMA: &str = "mlr.simulation/1";

/// The JSON object about the log.
#[derive(Serialize, JsonSchema)]
pub(super) struct Report<'a> {
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    log: &'a Path,
    /// The file of joint angles, if one was asked for.
    joints: Option<&'a Path>,
    morphology: &'a Morphology,
    /// Numbered from 1.
    damaged_legs: Vec<usize>,
    samples: usize,
    motion_start_s: f64,
}

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

/// Distance between the grid points of the rubble.
const RUBBLE_SPACING_M: f64 = 0.05;

pub(super) fn run(options: &SimulateOptions) -> anyhow::Result<()> {
    let settings = options.settings()?;
    let (robot, gait) = options.model.read()?;
    let robot = options.with_gears(robot)?;
    let morphology = options.morphology.of(&robot.layout())?;
    let joints = match &options.joints {
        Some(path) => {
            let file = ResultFile::reserve(path)?;
            let joints = JointTrajectory::commanded(&robot, &gait, settings.duration_s)
                .and_then(|joints| joints.to_csv(&robot))
                .with_context(|| path.display().to_string())?;
            Some((file, joints))
        }
        None => None,
    };
    let simulator = Simulator::new(robot.clone(), &gait, settings)?;
    let orientation = match simulator.simulate(&morphology) {
        Outcome::Walked(trajectory) => trajectory.orientation,
        Outcome::Diverged { at_s } => bail!(
            "the simulation of {morphology} diverged at {at_s:.3} s; a shorter --time-step-s may help"
        ),
    };
    // Log time starts with the recording, gait time with the walk, by the robot's own clock.
    let orientation = robot.imu().on(&orientation);
    let times_s = orientation
        .times_s()
        .iter()
        .map(|gait_time_s| gait_time_s.min(0.0) + gait_time_s.max(0.0) * robot.clock())
        .map(|time_s| time_s + options.stand_s)
        .collect();
    let log = OrientationSeries::new(times_s, orientation.angles_rad().clone())?;
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
    output::result(&options.report(&morphology, log.len())?)?;
    Ok(())
}

impl SimulateOptions {
    fn report(&self, morphology: &Morphology, samples: usize) -> serde_json::Result<String> {
        if self.json {
            let report = Report {
                schema: SCHEMA,
                log: &self.output,
                joints: self.joints.as_deref(),
                morphology,
                damaged_legs: morphology.damaged_legs(),
                samples,
                motion_start_s: self.stand_s,
            };
            Ok(serde_json::to_string(&report)? + "\n")
        } else {
            Ok(format!(
                "{}: {samples} samples, {}, walking from {} s on\n",
                self.output.display(),
                morphology.describe(),
                self.stand_s
            ))
        }
    }

    /// The robot with friction and play in its joints.
    fn with_gears(&self, robot: Robot) -> Result<Robot, ModelError> {
        let (friction_nm, backlash_rad) = (self.joint_friction_nm, self.backlash_rad);
        SettingError::check("--joint-friction-nm", friction_nm, 0.0..=1e6, "N m")?;
        SettingError::check("--backlash-rad", backlash_rad, 0.0..=1.0, "rad")?;
        let mut servo = *robot.servo();
        servo.drive.coulomb_nm += friction_nm;
        servo.drive.backlash_rad += backlash_rad;
        robot.with_servo(servo)
    }

    fn settings(&self) -> Result<SimulationSettings, SettingError> {
        // The only two options in another unit than the setting.
        let steepest_deg = Terrain::STEEPEST_DEG;
        SettingError::check("--slope-deg", self.slope_deg, 0.0..=steepest_deg, "degrees")?;
        SettingError::check("--uphill-deg", self.uphill_deg, -360.0..=360.0, "degrees")?;
        let settings = SimulationSettings {
            duration_s: self.walk_s,
            stand_s: self.stand_s,
            time_step_s: self.time_step_s,
            lost_links: self.lost_links.into(),
            contact: GroundContact {
                friction: self.friction,
                ..Default::default()
            },
            terrain: Terrain {
                slope_rad: self.slope_deg.to_radians(),
                uphill_rad: self.uphill_deg.to_radians(),
                roughness: self.rubble_m.map(|height_m| Roughness {
                    height_m,
                    spacing_m: RUBBLE_SPACING_M,
                    seed: self.seed,
                }),
            },
            ..Default::default()
        };
        let checked = settings.check().map_err(|error| {
            error.as_option(&[
                ("duration_s", "--walk-s"),
                ("stand_s", "--stand-s"),
                ("time_step_s", "--time-step-s"),
                ("contact.friction", "--friction"),
                ("terrain.roughness.height_m", "--rubble-m"),
            ])
        });
        checked.map(|()| settings)
    }
}
