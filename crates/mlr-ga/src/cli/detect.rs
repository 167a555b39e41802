//! `mlr-ga detect`.

use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use mlr_ga::{Detection, DetectionSettings, detect};
use schemars::JsonSchema;
use serde::Serialize;

use super::{
    log_file::LogFile,
    model_files::{self, MethodName},
    output::{self, ResultFile},
    plot,
};

/// Version of the JSON output.
const SCHEMA: &str = "mlr.detection/1";

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

/// The JSON object.
#[derive(Serialize, JsonSchema)]
pub(super) struct Report<'a> {
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    log: &'a PathBuf,
    #[serde(flatten)]
    detection: &'a Detection,
}

pub(super) fn run(options: &DetectOptions) -> anyhow::Result<()> {
    let configuration = model_files::configuration(options.config.as_deref(), options.method)?;
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
    let report = Report {
        schema: SCHEMA,
        log: options.log.path(),
        detection: &detection,
    };
    let text = if options.json {
        serde_json::to_string(&report).context("JSON")? + "\n"
    } else {
        report.table()
    };
    output::result(&text)?;
    Ok(())
}

impl Report<'_> {
    /// The answer for people.
    fn table(&self) -> String {
        let detection = self.detection;
        let mut table = output::Table::default();
        table.line("log", self.log.display());
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
}
