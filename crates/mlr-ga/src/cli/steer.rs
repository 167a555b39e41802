//! `mlr-ga steer`.

use std::path::PathBuf;

use clap::Args;
use mlr_ga::{Configuration, DetectionSettings, Model, SteeringReport, gait_of_json, steer};
use mlr_model::Robot;

use super::{
    log_file::{ReadOptions, blame_if},
    model_files::ModelFiles,
    motion_files::MotionFiles,
    output,
    recover::{damage, swings},
    saved_answer::saved_answer,
};

#[derive(Debug, Args)]
pub(super) struct SteerOptions {
    /// The gait that the robot walked: what recover or steer printed with --json, or an event of the
    /// daemon with it.
    #[arg(value_name = "RECOVERY")]
    recovery: PathBuf,
    /// A log of the robot that stands, and then walks with this gait.
    #[arg(value_name = "LOG")]
    log: PathBuf,
    #[command(flatten)]
    read: ReadOptions,
    #[command(flatten)]
    files: MotionFiles,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
    /// All settings, in TOML, such as the daemon's /etc/mlrd.toml.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    #[command(flatten)]
    model: ModelFiles,
}

pub(super) fn run(options: &SteerOptions) -> anyhow::Result<()> {
    let Configuration {
        identification,
        mounting,
        recovery,
        ..
    } = Configuration::read(options.config.as_deref(), None)?;
    let (robot, nominal) = options.model.read()?;
    let files = options.files.reserve()?;
    let gait = saved_answer(&options.recovery, |text| gait_of_json(text, &robot))?;
    let recording = options.read.recording(&options.log)?.mounted(&mounting)?;
    let model = Model::new(&robot, &nominal);
    let detection = DetectionSettings::from(&identification);
    let found = steer(&recording, &gait, model, &detection, &recovery).map_err(|error| {
        let of_the_log = error.is_recordings_fault();
        blame_if(of_the_log, &options.log, error.into())
    })?;
    for warning in &found.warnings {
        output::warning(warning);
    }
    files.write(&found.steered.gait, &robot)?;
    let report = SteeringReport::new(options.log.display().to_string(), &gait, &found);
    let text = match options.json {
        true => serde_json::to_string(&report)? + "\n",
        false => table(&report, options, &robot),
    };
    Ok(output::result(&text)?)
}

/// The report for people.
fn table(report: &SteeringReport, options: &SteerOptions, robot: &Robot) -> String {
    let mut table = output::Table::default();
    table.line("log", &report.log);
    table.line("damage", damage(&report.gait, robot));
    let deviation = report.turned_deviation_deg;
    table.line(
        "turned",
        format!(
            "{:+.2}°{} a cycle over {} cycles, {:+.1} °/m of the gait's way",
            report.turned_deg,
            deviation.map_or(String::new(), |deg| format!(" ± {deg:.2}°")),
            report.cycles,
            report.drift_deg_per_m,
        ),
    );
    options.files.name("gait", "", &mut table);
    table.line("swings", swings(&report.gait));
    table.line(
        "steering",
        format!(
            "{:+.2}° a cycle in place of {:+.2}°",
            report.gait.steering_deg, report.steering_before_deg
        ),
    );
    table.line(
        "stability",
        format!(
            "centre of mass {:.0} mm inside the feet that stand, {:.0} mm on the way into the gait",
            1e3 * report.margin_m,
            1e3 * report.first_steps_margin_m
        ),
    );
    table.into_text()
}
