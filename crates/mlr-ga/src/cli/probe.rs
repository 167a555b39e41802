//! `mlr-ga probe`.

mod calibration;
mod diagnosis;

use std::path::PathBuf;

use anyhow::bail;
use clap::{Args, builder::PossibleValuesParser};
use mlr_ga::{LARGEST_SEED, ProbeSettings, ReportedSegment};
use mlr_residual::{walk::MotionBounds, walk_effects::LIBRARY};

use super::{
    atlas_files::AtlasFiles, log_file::ReadOptions, model_files::ModelOfLogs,
    motion_files::MotionFiles,
};

#[derive(Debug, Args)]
pub(super) struct ProbeOptions {
    /// The logs of one robot that leave something open, read as by identify.
    #[arg(value_name = "LOG")]
    logs: Vec<PathBuf>,
    #[command(flatten)]
    read: ReadOptions,
    /// Look for the motion of a healthy robot that tells most about its own parameters, instead of the
    /// one that tells most about what a log leaves open.
    #[arg(long)]
    calibrate: bool,
    /// Look for the motion that tells most about what this explanation leaves open, as explain printed it
    /// with --json: a slope or a tilted sensor, a payload or a pull. It takes the place of the logs.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["logs", "calibrate"])]
    explanation: Option<PathBuf>,
    /// Ask about this kind of effect as well, whatever the explanation says of it: a payload or a pull hardly shows in
    /// a walk on all legs. Wherever it is and of any size that its prior has; several with commas. The robot walks with
    /// one leg folded then, too.
    #[arg(long, value_name = "KIND", value_delimiter = ',', value_parser = kinds_of_the_body())]
    ask: Vec<String>,
    #[command(flatten)]
    files: MotionFiles,
    /// How long the motion may last [default: 20 s; 30 s with --calibrate].
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    max_s: Option<f64>,
    /// How far the body may tilt, of every robot of the make that is tried.
    #[arg(long, value_name = "DEGREES", default_value_t = ProbeSettings::default().bounds.tilt_deg, allow_negative_numbers = true)]
    max_tilt_deg: f64,
    /// How many robots of the make are tried for a motion that calibrates. Fewer take less time, and the motion keeps
    /// its bounds less surely.
    #[arg(long, value_name = "N", default_value_t = ProbeSettings::default().robots, requires = "calibrate")]
    robots: usize,
    /// Chooses the robots of the make that are tried.
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true,
          value_parser = clap::value_parser!(u64).range(..=LARGEST_SEED))]
    seed: u64,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
    /// All settings, in TOML, such as the daemon's /etc/mlrd.toml.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    #[command(flatten)]
    atlas: AtlasFiles,
    #[command(flatten)]
    model: ModelOfLogs,
}

pub(super) fn run(options: &ProbeOptions) -> anyhow::Result<()> {
    let settings = ProbeSettings {
        longest_s: options.max_s.unwrap_or(match options.calibrate {
            true => ProbeSettings::default().longest_s,
            false => LONGEST_DIAGNOSIS_S,
        }),
        bounds: MotionBounds {
            tilt_deg: options.max_tilt_deg,
        },
        robots: options.robots,
        seed: options.seed,
        ..ProbeSettings::default()
    };
    settings.check().map_err(|error| {
        error.as_option(&[
            ("longest_s", "--max-s"),
            ("bounds.tilt_deg", "--max-tilt-deg"),
            ("robots", "--robots"),
        ])
    })?;
    if !options.ask.is_empty() && options.explanation.is_none() {
        bail!(
            "--ask without an explanation: expected --explanation FILE, as explain printed it with --json"
        );
    }
    let asks = !options.logs.is_empty() || options.explanation.is_some();
    match (asks, options.calibrate) {
        (false, true) => calibration::run(options, settings),
        (true, false) => diagnosis::run(options, settings),
        (false, false) => bail!(
            "which motion? expected LOG, for the one that tells most about what the log leaves open, \
             --explanation, for the one that tells which of the effects it is, or --calibrate, for \
             the one that calibrates a healthy robot"
        ),
        (true, true) => bail!("a log with --calibrate: expected one of the two"),
    }
}

/// What changes how the body moves in a motion, rather than the sensor's signals or the time of the start.
fn kinds_of_the_body() -> PossibleValuesParser {
    let effects = LIBRARY.iter();
    let of_the_body = effects.filter(|effect| !effect.is_of_sensing() && !effect.is_a_delay());
    PossibleValuesParser::new(of_the_body.map(|effect| effect.kind()))
}

/// A diagnosis motion lasts no longer unless asked to.
const LONGEST_DIAGNOSIS_S: f64 = 20.0;

fn segment(segment: &ReportedSegment) -> String {
    let ReportedSegment {
        motion,
        duration_s,
        gain_nats,
    } = segment;
    format!("{motion}: {duration_s:.1} s, {gain_nats:.2} nats")
}
