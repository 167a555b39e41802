//! `mlr-ga identify`.

use std::{path::PathBuf, time::Instant};

use clap::{Args, ValueEnum};
use mlr_filter::SettingError;
use mlr_ga::{
    IdentificationReport, IdentifySettings, LogReport, LossHypothesis, Method, Search,
    identify_together,
};
use mlr_model::Robot;

use super::{
    atlas_files::AtlasFiles,
    log_file::LogFiles,
    model_files::{self, MethodName, ModelOfLogs},
    output::{self, ResultFile},
    plot,
    progress::Bar,
    search_options::SearchOptions,
};

#[derive(Debug, Args)]
pub(super) struct IdentifyOptions {
    #[command(flatten)]
    logs: LogFiles,
    #[command(flatten)]
    search: SearchOptions,
    /// What decides [default: mlr].
    #[arg(long, value_enum)]
    method: Option<MethodName>,
    /// Run the genetic algorithm N times, and report how often it found which morphology [default:
    /// 1; 10 with --method paper].
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    repeats: Option<usize>,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
    /// Draw measured and simulated roll, pitch and yaw into this SVG file: of several logs, those of
    /// the first. An existing file is never overwritten.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Length of the compared stretch [default: 5 s].
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    window_s: Option<f64>,
    /// Log time at which the compared stretch begins [default: the start of the walk, or when damage
    /// is flagged in mid-walk]. Of one log only.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    from_s: Option<f64>,
    /// What lost links may have become [default: either].
    #[arg(long, value_enum)]
    lost_links: Option<LossName>,
    /// Friction between feet and ground [default: 0.7].
    #[arg(long, value_name = "MU", allow_negative_numbers = true)]
    friction: Option<f64>,
    /// All settings, in TOML, such as the daemon's /etc/mlrd.toml; options override it.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    #[command(flatten)]
    atlas: AtlasFiles,
    #[command(flatten)]
    model: ModelOfLogs,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum LossName {
    /// Gone.
    Absent,
    /// Locked clear of the ground.
    Locked,
    /// Whichever fits better.
    Either,
}

pub(super) fn run(options: &IdentifyOptions) -> anyhow::Result<()> {
    let started = Instant::now();
    let configuration = model_files::configuration(options.config.as_deref(), options.method)?;
    let settings = options.settings(configuration.identification)?;
    let (robot, _, gaits) = options.model.read(options.logs.paths().len())?;
    settings.check_on(&robot)?;
    let picture = options.plot.as_deref();
    let picture = picture.map(ResultFile::reserve).transpose()?;
    let recordings = options.logs.read(&configuration.mounting)?;
    let atlases = options.atlas.open(&robot, &gaits, &settings)?;
    let walks = atlases.walks(&recordings, &gaits);
    let bar = Bar::new();
    let answer = identify_together(&walks, &robot, &settings, &bar);
    bar.clear();
    let identification = answer.map_err(|(log, error)| options.logs.blame(log, error))?;
    let files = options.logs.names();
    if files.len() > 1 {
        for (file, log) in files.iter().zip(&identification.logs) {
            for warning in &log.warnings {
                output::warning(&format!("{file}: {warning}"));
            }
        }
    }
    for warning in &identification.warnings {
        output::warning(warning);
    }
    if let Some(file) = picture {
        let (name, error_deg) = (&identification.description, identification.mean_error_deg);
        file.write(&plot::signals(name, error_deg, &identification.signals)?)?;
    }
    let report = IdentificationReport::of_files(files, identification, started.elapsed());
    let text = if options.json {
        serde_json::to_string(&report)? + "\n"
    } else {
        table(&report, &robot)
    };
    output::result(&text)?;
    Ok(())
}

impl IdentifyOptions {
    /// The settings of the file, which were checked, with the options in their place.
    fn settings(&self, settings: IdentifySettings) -> Result<IdentifySettings, SettingError> {
        let mut settings = self.search.over(settings);
        if let Some(window_s) = self.window_s {
            settings.window_s = window_s;
        }
        settings.from_s = self.from_s.or(settings.from_s);
        settings.genetic.repeats = self.repeats.unwrap_or(settings.genetic.repeats);
        if let Some(friction) = self.friction {
            settings.simulation.contact.friction = friction;
        }
        if let Some(lost_links) = self.lost_links {
            settings.lost_links = match lost_links {
                LossName::Absent => LossHypothesis::Absent,
                LossName::Locked => LossHypothesis::Locked,
                LossName::Either => LossHypothesis::Either,
            };
        }
        let checked = settings.check().map_err(|error| {
            error.as_option(&[
                ("window_s", "--window-s"),
                ("from_s", "--from-s"),
                ("genetic.repeats", "--repeats"),
                ("simulation.contact.friction", "--friction"),
            ])
        });
        checked.map(|()| settings)
    }
}

/// The answer for people.
fn table(report: &IdentificationReport, robot: &Robot) -> String {
    let answer = &report.identification;
    let description = answer.morphology.describe_on(robot);
    let mut table = output::Table::default();
    match report.logs.is_empty() {
        true => table.line("log", &report.log),
        false => table.lines("logs", report.logs.iter().map(log_line)),
    }
    let morphology = format!("{}  {}", answer.morphology, percent(answer.probability));
    if answer.implausible {
        let doubt = percent(answer.something_else_probability.unwrap_or_default());
        table.line(
            "damage",
            format!("not known: no morphology explains this log ({doubt})"),
        );
        table.line("closest", format!("{description}: {morphology}"));
    } else {
        table.line("damage", description);
        table.line("morphology", morphology);
    }
    table.line(
        "legs damaged",
        answer
            .leg_damage_probability
            .iter()
            .enumerate()
            .map(|(leg, probability)| format!("{}: {}", leg + 1, percent(*probability)))
            .collect::<Vec<_>>()
            .join("  "),
    );
    table.line(
        "error",
        format!(
            "{:.2}° per sample and axis (F = {:.2} rad)",
            answer.mean_error_deg, answer.cost_rad
        ),
    );
    let doubt = answer.something_else_probability.unwrap_or_default();
    if !answer.implausible && doubt >= WORTH_A_LINE {
        let doubt = percent(doubt);
        table.line(
            "doubt",
            format!("{doubt} that something else decides how the robot walks"),
        );
    }
    if answer.method == Method::Paper {
        table.line(
            "method",
            "the paper's: least F; percentages are shares of its runs",
        );
    }
    if report.logs.is_empty() {
        match answer.motion_start_s {
            Some(start_s) => table.line("walk starts", format!("{start_s:.2} s")),
            None => table.line("walk starts", "before the log"),
        }
        table.line(
            "compared",
            format!(
                "{:.1} s from {:.2} s on",
                answer.window_s, answer.window_start_s
            ),
        );
    }
    table.line(
        "search",
        format!(
            "{} morphologies in {:.1} s ({})",
            answer.evaluations,
            report.elapsed_s,
            match answer.search {
                Search::Ga => "genetic algorithm",
                Search::Exact => "all that are feasible, simulated",
                Search::Atlas => "all that are feasible, from the atlas",
            }
        ),
    );
    if answer.diverged > 0 {
        table.line("diverged", format!("{} simulations", answer.diverged));
    }
    table.lines(
        "runs",
        answer.frequencies.iter().map(|frequency| {
            format!(
                "{} × {}  cost {:.3}°",
                frequency.count, frequency.morphology, frequency.cost_deg
            )
        }),
    );
    table.line(
        "alike",
        match answer.indistinguishable.len() {
            0 => "no other morphology".to_string(),
            1 => "1 other morphology".into(),
            more => format!("{more} other morphologies"),
        },
    );
    table.lines(
        "next best",
        answer.alternatives.iter().map(|alternative| {
            format!(
                "{}  {}  F = {:.2} rad",
                alternative.morphology,
                percent(alternative.probability),
                alternative.cost_rad
            )
        }),
    );
    table.into_text()
}

/// What one of several logs says.
fn log_line(log: &LogReport) -> String {
    format!(
        "{}: {:.1} s from {:.2} s on, {:.2}° per sample and axis",
        log.file, log.log.window_s, log.log.window_start_s, log.log.mean_error_deg
    )
}

/// Below this, a probability that something else is wrong is not worth a line.
const WORTH_A_LINE: f64 = 0.05;

/// A probability that is neither 0 nor 1 is not shown as such.
fn percent(probability: f64) -> String {
    match 100.0 * probability {
        p if p > 0.0 && p < 0.5 => "< 1 %".into(),
        p if p < 100.0 && p > 99.5 => "> 99 %".into(),
        p => format!("{p:.0} %"),
    }
}
