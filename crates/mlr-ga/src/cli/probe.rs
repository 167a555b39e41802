//! `mlr-ga probe`.

use std::path::PathBuf;

use anyhow::bail;
use clap::Args;
use mlr_ga::{
    Configuration, LARGEST_SEED, ProbeReport, ProbeSettings, ReportedSegment, calibration_motion,
};
use mlr_model::Motion;
use mlr_residual::walk::MotionBounds;

use super::{
    model_files::{self, ModelFiles},
    output::{self, ResultFile},
    progress::Bar,
};

#[derive(Debug, Args)]
pub(super) struct ProbeOptions {
    /// Look for the motion of a healthy robot that tells most about its own parameters. The only
    /// motion there is so far.
    #[arg(long)]
    calibrate: bool,
    /// Write the motion to this file, a gait in TOML that every command takes as --gait. An existing
    /// file is never overwritten.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Also write it as the joint angles that a controller plays, as CSV. An existing file is never
    /// overwritten.
    #[arg(long, value_name = "FILE")]
    joints: Option<PathBuf>,
    /// How long the motion may last.
    #[arg(long, value_name = "SECONDS", default_value_t = ProbeSettings::default().longest_s, allow_negative_numbers = true)]
    max_s: f64,
    /// How far the body may tilt, of every robot of the make that is tried.
    #[arg(long, value_name = "DEGREES", default_value_t = ProbeSettings::default().bounds.tilt_deg, allow_negative_numbers = true)]
    max_tilt_deg: f64,
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
    model: ModelFiles,
}

pub(super) fn run(options: &ProbeOptions) -> anyhow::Result<()> {
    if !options.calibrate {
        bail!("which motion? expected --calibrate, for the one that calibrates a healthy robot");
    }
    let settings = ProbeSettings {
        longest_s: options.max_s,
        bounds: MotionBounds {
            tilt_deg: options.max_tilt_deg,
        },
        seed: options.seed,
        ..ProbeSettings::default()
    };
    settings.check().map_err(|error| {
        error.as_option(&[
            ("longest_s", "--max-s"),
            ("bounds.tilt_deg", "--max-tilt-deg"),
        ])
    })?;
    let Configuration {
        identification,
        explanation,
        ..
    } = model_files::configuration(options.config.as_deref(), None)?;
    let (robot, gait) = options.model.read()?;
    if gait.feet().is_none() {
        bail!(
            "{}: a joint trajectory, expected the motion of feet as --gait",
            gait.name
        );
    }
    let file = ResultFile::reserve(&options.output)?;
    let joints_file = options.joints.as_deref().map(ResultFile::reserve);
    let joints_file = joints_file.transpose()?;
    let bar = Bar::of_motions();
    let simulation = &identification.simulation;
    let found = calibration_motion(&robot, &gait, simulation, &explanation, settings, &bar);
    bar.clear();
    let motion = found?;
    file.write(&motion.gait.to_toml())?;
    if let (Some(file), Motion::Joints(joints)) = (joints_file, &motion.gait.motion) {
        file.write(&joints.to_csv(&robot)?)?;
    }
    let report = ProbeReport::new(&motion, &explanation.nuisance);
    let text = match options.json {
        true => serde_json::to_string(&report)? + "\n",
        false => table(&report, options),
    };
    Ok(output::result(&text)?)
}

/// The report for people.
fn table(report: &ProbeReport, options: &ProbeOptions) -> String {
    let mut table = output::Table::default();
    let duration_s = report.duration_s;
    table.line(
        "motion",
        format!("{}, {duration_s:.1} s", options.output.display()),
    );
    if let Some(joints) = &options.joints {
        table.line("joints", joints.display());
    }
    table.lines("folded legs", report.segments.iter().map(segment));
    let left_out = report.left_out.iter();
    let left_out: Vec<String> = left_out
        .map(|(why, count)| format!("{count} {why}"))
        .collect();
    let reasons = match left_out.is_empty() {
        true => String::new(),
        false => format!("; left out: {}", left_out.join(", ")),
    };
    table.line("segments", format!("{} tried{reasons}", report.candidates));
    table.line(
        "information",
        format!(
            "{:.1} nats, a plain walk {:.1} nats; means over {} robots of the make",
            report.motion_gain_nats, report.walk_gain_nats, report.robots
        ),
    );
    table.line(
        "",
        format!("{:<18} {:>4}  ± before  after walk  after motion", "", ""),
    );
    let lines = report.parameters.iter().map(|one| {
        format!(
            "{:<18} {:>4} {:9.4} {:11.4} {:13.4}",
            one.name, one.unit, one.before, one.after_walk, one.after_motion
        )
    });
    table.lines("", lines);
    table.into_text()
}

fn segment(segment: &ReportedSegment) -> String {
    let legs: Vec<String> = segment.folded_legs.iter().map(usize::to_string).collect();
    let legs = match legs.is_empty() {
        true => "none".to_string(),
        false => legs.join(", "),
    };
    format!(
        "{legs:<6} stride {:3.0} mm, lift {:3.0} mm, period {:.1} s: {:4.1} s, {:5.1} nats alone",
        1e3 * segment.stride_m,
        1e3 * segment.lift_m,
        segment.period_s,
        segment.duration_s,
        segment.gain_nats
    )
}
