//! `mlr-ga detect`.

use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use mlr_ga::{Configuration, DetectionReport, DetectionSettings, Method, detect};

use super::{
    log_file::LogFile,
    model_files::MethodName,
    output::{self, ResultFile},
    plot,
};

#[derive(Debug, Args)]
pub(super) struct DetectOptions {
    #[command(flatten)]
    log: LogFile,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
    /// Draw roll, pitch and yaw, and the fluctuation with its threshold and flag, into this SVG file.
    /// An existing file is never overwritten.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// The detector's rule [default: mlr, which forgives a lull; paper: without one].
    #[arg(long, value_enum)]
    method: Option<MethodName>,
    /// All settings, in TOML, such as the daemon's /etc/mlrd.toml.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

pub(super) fn run(options: &DetectOptions) -> anyhow::Result<()> {
    let configuration =
        Configuration::read(options.config.as_deref(), options.method.map(Method::from))?;
    let settings = DetectionSettings::from(&configuration.identification);
    let picture = options.plot.as_deref();
    let picture = picture.map(ResultFile::reserve).transpose()?;
    let recording = options.log.read()?.mounted(&configuration.mounting)?;
    let detection = detect(&recording, &settings).map_err(|error| options.log.blame(error))?;
    for warning in &detection.warnings {
        output::warning(warning);
    }
    if let Some(file) = picture {
        file.write(&plot::detection(&detection, &recording.orientation)?)?;
    }
    let report = DetectionReport::new(options.log.path().display().to_string(), detection);
    let text = if options.json {
        serde_json::to_string(&report).context("JSON")? + "\n"
    } else {
        table(&report)
    };
    output::result(&text)?;
    Ok(())
}

/// The answer for people.
fn table(report: &DetectionReport) -> String {
    let detection = &report.detection;
    let mut table = output::Table::default();
    table.line("log", &report.log);
    match detection.motion_start_s {
        Some(start_s) => table.line("walk starts", format!("{start_s:.2} s")),
        None => table.line("walk starts", "not in the log"),
    }
    match detection.damage_s {
        Some(damage_s) => table.line("damage", format!("flagged at {damage_s:.2} s")),
        None => table.line("damage", "none"),
    }
    table.line(
        "fluctuation",
        format!(
            "up to {:.1}° (threshold {:.1}°)",
            detection.max_fluctuation_deg, detection.threshold_deg
        ),
    );
    table.into_text()
}
