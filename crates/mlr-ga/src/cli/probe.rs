//! `mlr-ga probe`.

use std::path::PathBuf;

use anyhow::bail;
use clap::Args;
use mlr_ga::{
    Configuration, DiagnosisReport, IdentifySettings, LARGEST_SEED, Model, OpenQuestion,
    ProbeReport, ProbeSettings, ReportedSegment, calibration_motion, diagnosis_motion, identify,
};
use mlr_model::Motion;
use mlr_residual::walk::MotionBounds;

use super::{
    log_file::{LogFile, ReadOptions},
    model_files::{self, AtlasFile, ModelFiles},
    output::{self, ResultFile},
    progress::Bar,
};

#[derive(Debug, Args)]
pub(super) struct ProbeOptions {
    /// The log that leaves something open, read as by identify.
    log: Option<PathBuf>,
    #[command(flatten)]
    read: ReadOptions,
    /// Look for the motion of a healthy robot that tells most about its own parameters, instead of the
    /// one that tells most about what a log leaves open.
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
    /// How long the motion may last [default: 20 s; 30 s with --calibrate].
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    max_s: Option<f64>,
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
    atlas: AtlasFile,
    #[command(flatten)]
    model: ModelFiles,
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
        seed: options.seed,
        ..ProbeSettings::default()
    };
    settings.check().map_err(|error| {
        error.as_option(&[
            ("longest_s", "--max-s"),
            ("bounds.tilt_deg", "--max-tilt-deg"),
        ])
    })?;
    match (&options.log, options.calibrate) {
        (None, true) => {}
        (Some(log), false) => {
            let log = LogFile::new(log.clone(), options.read.clone());
            return diagnose(&log, options, settings);
        }
        (None, false) => bail!(
            "which motion? expected LOG, for the one that tells most about what the log leaves open, \
             or --calibrate, for the one that calibrates a healthy robot"
        ),
        (Some(_), true) => bail!("a log with --calibrate: expected one of the two"),
    }
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

/// The motion that tells most about what the log leaves open.
fn diagnose(log: &LogFile, options: &ProbeOptions, settings: ProbeSettings) -> anyhow::Result<()> {
    let configuration = model_files::configuration(options.config.as_deref(), None)?;
    let identification = IdentifySettings {
        seed: options.seed,
        ..configuration.identification
    };
    let (robot, gait) = options.model.read()?;
    identification.check_on(&robot)?;
    // The search varies steps of feet; the log may be of another motion.
    let steps = match gait.feet() {
        Some(_) => gait.clone(),
        None => mlr_model::Gait::tripod(),
    };
    let recording = log.read()?.mounted(&configuration.mounting)?;
    let atlas = options.atlas.open(&robot, &gait, &identification)?;
    let file = ResultFile::reserve(&options.output)?;
    let joints_file = options.joints.as_deref().map(ResultFile::reserve);
    let joints_file = joints_file.transpose()?;
    let bar = Bar::new();
    let model = Model::new(&robot, &gait).with_atlas(&atlas);
    let answer = identify(&recording, model, &identification, &bar);
    bar.clear();
    let answer = answer.map_err(|error| log.blame(error))?;
    let question = OpenQuestion::of(&answer);
    let motion = match question.is_sure() {
        true => None,
        false => {
            let bar = Bar::of_motions();
            let found =
                diagnosis_motion(&question, &robot, &steps, &identification, settings, &bar);
            bar.clear();
            Some(found?)
        }
    };
    let found = motion.as_ref().and_then(|motion| motion.gait.as_ref());
    if let Some(gait) = found {
        file.write(&gait.to_toml())?;
        if let (Some(file), Motion::Joints(joints)) = (joints_file, &gait.motion) {
            file.write(&joints.to_csv(&robot)?)?;
        }
    }
    let report = DiagnosisReport::new(&question, motion.as_ref());
    let text = match options.json {
        true => serde_json::to_string(&report)? + "\n",
        false => diagnosis_table(&report, options),
    };
    Ok(output::result(&text)?)
}

/// The report of a diagnosis motion for people.
fn diagnosis_table(report: &DiagnosisReport, options: &ProbeOptions) -> String {
    let mut table = output::Table::default();
    table.lines(
        "open",
        report
            .open
            .iter()
            .map(|one| format!("{}  {:.0} %", one.morphology, 100.0 * one.probability)),
    );
    match (report.sure, report.segments.is_empty()) {
        (true, _) => table.line("motion", "none: nothing to tell apart"),
        (false, true) => table.line("motion", "none that keeps the bounds tells more"),
        (false, false) => {
            let duration_s = report.duration_s;
            let file = options.output.display();
            table.line("motion", format!("{file}, {duration_s:.1} s"));
            if let Some(joints) = &options.joints {
                table.line("joints", joints.display());
            }
        }
    }
    table.lines("folded legs", report.segments.iter().map(segment));
    if !report.sure {
        let (tried, bounded) = (report.candidates, report.bounded);
        table.line(
            "segments",
            format!("{tried} tried, {bounded} keep the bounds"),
        );
    }
    table.line(
        "entropy",
        format!(
            "{:.2} nats, after the motion {:.2} nats expected",
            report.entropy_before_nats, report.entropy_after_nats
        ),
    );
    table.into_text()
}

/// A diagnosis motion lasts no longer unless asked to.
const LONGEST_DIAGNOSIS_S: f64 = 20.0;

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
        "{legs:<6} stride {:3.0} mm, lift {:3.0} mm, period {:.1} s: {:4.1} s, {:5.1} nats",
        1e3 * segment.stride_m,
        1e3 * segment.lift_m,
        segment.period_s,
        segment.duration_s,
        segment.gain_nats
    )
}
