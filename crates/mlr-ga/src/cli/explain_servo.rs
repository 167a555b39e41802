//! `mlr-ga explain-servo`.

use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use anyhow::Context;
use clap::Args;
use mlr_imu::read_text;
use mlr_model::bench::Bench;
use mlr_residual::servo::{
    ServoExplanation, ServoModel, ServoRecording, ServoSettings, TracedServoEffect, explain_servo,
};
use schemars::JsonSchema;
use serde::Serialize;

use super::{
    log_file::TableOptions,
    output::{self, ResultFile},
    plot,
    progress::Bar,
};

/// Version of the JSON output.
const SCHEMA: &str = "mlr.servo_explanation/1";
/// The most that is read of the description of a bench.
const MAX_BENCH_BYTES: u64 = 1_000_000;

#[derive(Debug, Args)]
pub(super) struct ExplainServoOptions {
    /// The bench, in TOML: the arm, and the servo as its data sheet has it.
    bench: PathBuf,
    /// Recordings that effects are chosen and fitted on: .csv or .csv.gz with the columns t_s, goal_rad
    /// and position_rad, and torque_enabled, volts, p_gain and load where they are known.
    #[arg(value_name = "RECORDING", required = true)]
    recordings: Vec<PathBuf>,
    /// A recording that only the error before and after is measured on; may be repeated.
    #[arg(long, value_name = "RECORDING")]
    test: Vec<PathBuf>,
    /// Fit these kinds of effects, and look for no others: KIND[,KIND…].
    #[arg(long, value_name = "KINDS", value_delimiter = ',')]
    effects: Option<Vec<String>>,
    /// Do not try this kind of effect; may be repeated.
    #[arg(long, value_name = "KIND")]
    without: Vec<String>,
    /// Write the servo with its effects to this file, as the [servo] section of a robot description.
    /// An existing file is never overwritten.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write goal, measured angle, and the servo before and after of every recording to this file, as
    /// SVG.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    table: TableOptions,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

/// The JSON object of an explanation.
#[derive(Serialize, JsonSchema)]
pub(super) struct Report<'a> {
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    bench: &'a Path,
    #[serde(flatten)]
    explanation: &'a ServoExplanation,
    elapsed_s: f64,
}

/// The section of a robot description.
#[derive(Serialize, JsonSchema)]
struct Section {
    servo: mlr_model::Servo,
}

pub(super) fn run(options: &ExplainServoOptions) -> anyhow::Result<()> {
    let started = Instant::now();
    let settings = ServoSettings {
        effects: options.effects.clone(),
        without: options.without.clone(),
    };
    let checked = settings.check();
    checked
        .map_err(|error| error.as_option(&[("effects", "--effects"), ("without", "--without")]))?;
    let name = || options.bench.display().to_string();
    let text = read_text(&options.bench, MAX_BENCH_BYTES).with_context(name)?;
    let described = ServoModel::new(Bench::from_toml(&text).with_context(name)?);
    let reserve = |path: &PathBuf| ResultFile::reserve(path);
    let section = options.output.as_ref().map(reserve).transpose()?;
    let picture = options.plot.as_ref().map(reserve).transpose()?;
    let fitted = options.read(&options.recordings)?;
    let unseen = options.read(&options.test)?;
    let bar = Bar::of_steps();
    let found = explain_servo(&described, &fitted, &unseen, &settings, &bar);
    bar.clear();
    let found = found.map_err(|(index, error)| {
        let paths = options.recordings.iter().chain(&options.test);
        let of = paths
            .skip(index)
            .map(|path| path.display().to_string())
            .next();
        anyhow::Error::from(error).context(of.unwrap_or_default())
    })?;
    if unseen.is_empty() {
        output::warning(
            "no recording was kept away: the errors are those of recordings that effects were chosen \
             on; --test RECORDING measures them on another",
        );
    }
    if let Some(file) = section {
        let servo = Section { servo: found.servo };
        file.write(&toml::to_string(&servo)?)?;
    }
    if let Some(file) = picture {
        let recordings: Vec<&ServoRecording> = fitted.iter().chain(&unseen).collect();
        file.write(&plot::servo(&recordings, &found)?)?;
    }
    let report = Report {
        schema: SCHEMA,
        bench: &options.bench,
        explanation: &found,
        elapsed_s: started.elapsed().as_secs_f64(),
    };
    let text = match options.json {
        true => serde_json::to_string(&report)? + "\n",
        false => report.table(),
    };
    Ok(output::result(&text)?)
}

impl ExplainServoOptions {
    fn read(&self, paths: &[PathBuf]) -> anyhow::Result<Vec<ServoRecording>> {
        let each = paths.iter().map(|path| {
            let name = path.display().to_string();
            let recording = self
                .table
                .read(path, |table| ServoRecording::from_table(name, table))?;
            Ok(recording)
        });
        each.collect()
    }
}

impl Report<'_> {
    /// The answer for people.
    fn table(&self) -> String {
        let found = self.explanation;
        let mut table = output::Table::default();
        table.line("bench", self.bench.display());
        table.line(
            "effects",
            "in the order in which they entered, with what they added to ln probability, and the median error",
        );
        table.lines("", found.effects.iter().map(effect_text));
        let candidates = found
            .candidates
            .iter()
            .map(|one| format!("{:<19} {:+7.1}", one.kind, one.ln_gain));
        table.lines("did not enter", candidates);
        table.line("RMS error", "as described   with effects");
        for fitted in [true, false] {
            let of = found.recordings.iter().filter(|one| one.fitted == fitted);
            let lines = of.map(|one| {
                let name = output::file_name(&one.recording);
                format!("{:>11.2}° {:>13.2}°  {name}", one.before_deg, one.after_deg)
            });
            table.lines(if fitted { "  fitted" } else { "  unseen" }, lines);
        }
        table.line("time", format!("{:.0} s", self.elapsed_s));
        table.into_text()
    }
}

fn effect_text(effect: &TracedServoEffect) -> String {
    let parameters = effect.parameters.iter().map(|(name, value)| {
        let interval = effect.interval_95.get(name);
        let interval = interval.map_or(String::new(), |[low, high]| {
            format!(" ({low:.4} to {high:.4})")
        });
        format!("{name} {value:.4}{interval}")
    });
    let untold = match effect.undetermined.is_empty() {
        true => String::new(),
        false => format!("; not told: {}", effect.undetermined.join(", ")),
    };
    format!(
        "{:<19} {:+7.1} {:6.2}°  {}{untold}",
        effect.kind,
        effect.ln_gain,
        effect.fit_deg,
        parameters.collect::<Vec<_>>().join(", ")
    )
}
