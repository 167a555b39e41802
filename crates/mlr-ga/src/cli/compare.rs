//! `mlr-ga compare`.

use std::path::PathBuf;

use clap::Args;
use mlr_filter::Axes;
use mlr_ga::{ComparedSignals, Comparison, Configuration, Method, Model, compare};
use mlr_model::Robot;
use schemars::JsonSchema;
use serde::Serialize;

use super::{
    log_file::LogFile,
    model_files::{MethodName, ModelFiles},
    morphology_choice::MorphologyChoice,
    output::{self, ResultFile},
    plot,
};

/// Version of the JSON output.
const SCHEMA: &str = "mlr.comparison/1";

#[derive(Debug, Args)]
pub(super) struct CompareOptions {
    #[command(flatten)]
    log: LogFile,
    #[command(flatten)]
    morphology: MorphologyChoice,
    /// Whose settings are used [default: mlr].
    #[arg(long, value_enum)]
    method: Option<MethodName>,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
    /// Draw measured and simulated roll, pitch and yaw into this SVG file. An existing file is never
    /// overwritten.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Write measured and simulated roll, pitch and yaw, after Algorithm 2, into this CSV file. An
    /// existing file is never overwritten.
    #[arg(long, value_name = "FILE")]
    signals: Option<PathBuf>,
    /// All settings, in TOML, such as the daemon's /etc/mlrd.toml.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    #[command(flatten)]
    model: ModelFiles,
}

/// The JSON object.
#[derive(Serialize, JsonSchema)]
pub(super) struct Report<'a> {
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    log: &'a PathBuf,
    #[serde(flatten)]
    comparison: &'a Comparison,
}

pub(super) fn run(options: &CompareOptions) -> anyhow::Result<()> {
    let configuration =
        Configuration::read(options.config.as_deref(), options.method.map(Method::from))?;
    let (robot, gait) = options.model.read()?;
    let morphology = options.morphology.of(&robot.layout())?;
    let reserve = |path: &PathBuf| ResultFile::reserve(path);
    let picture = options.plot.as_ref().map(reserve).transpose()?;
    let signals = options.signals.as_ref().map(reserve).transpose()?;
    let recording = options.log.read()?.mounted(&configuration.mounting)?;
    let model = Model::new(&robot, &gait);
    let comparison = compare(&recording, model, &configuration.identification, morphology)
        .map_err(|error| options.log.blame(error))?;
    if let Some(file) = picture {
        let name = comparison.morphology.describe();
        file.write(&plot::signals(
            &name,
            comparison.mean_error_deg,
            &comparison.signals,
        )?)?;
    }
    if let Some(file) = signals {
        file.write(csv(&comparison.signals))?;
    }
    let report = Report {
        schema: SCHEMA,
        log: options.log.path(),
        comparison: &comparison,
    };
    let text = if options.json {
        serde_json::to_string(&report)? + "\n"
    } else {
        report.table(&robot)
    };
    Ok(output::result(&text)?)
}

impl Report<'_> {
    /// The answer for people.
    fn table(&self, robot: &Robot) -> String {
        let comparison = self.comparison;
        let mut table = output::Table::default();
        table.line("log", self.log.display());
        let morphology = &comparison.morphology;
        table.line(
            "morphology",
            format!("{morphology}  {}", morphology.describe_on(robot)),
        );
        let (error_deg, cost_rad) = (comparison.mean_error_deg, comparison.cost_rad);
        table.line(
            "error",
            format!("{error_deg:.2}° per sample and axis (F = {cost_rad:.2} rad)"),
        );
        table.line(
            "compared",
            format!("from {:.2} s on", comparison.window_start_s),
        );
        table.into_text()
    }
}

/// Time since the beginning of the compared stretch, and the angles in degrees.
fn csv(signals: &ComparedSignals) -> String {
    let mut text = String::from(
        "t_s,measured_roll_deg,measured_pitch_deg,measured_yaw_deg,\
         simulated_roll_deg,simulated_pitch_deg,simulated_yaw_deg\n",
    );
    let axes =
        |angles: &Axes<Vec<f64>>| angles.as_ref().map(|_, angles| angles.clone()).into_array();
    let columns = [axes(&signals.measured), axes(&signals.simulated)].concat();
    for row in 0..signals.measured.roll.len() {
        text += &format!("{:.4}", row as f64 / signals.rate_hz);
        for column in &columns {
            let angle_rad = column.get(row).copied().unwrap_or(f64::NAN);
            text += &format!(",{:.5}", angle_rad.to_degrees());
        }
        text.push('\n');
    }
    text
}
