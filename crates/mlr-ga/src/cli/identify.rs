//! `mlr-ga identify`.

use std::{path::PathBuf, time::Instant};

use clap::Args;
use mlr_ga::{IdentificationReport, LogReport, Method, Search};
use mlr_model::Robot;

use super::{
    identification::IdentificationOptions,
    output::{self, ResultFile},
    plot,
};

#[derive(Debug, Args)]
pub(super) struct IdentifyOptions {
    #[command(flatten)]
    identification: IdentificationOptions,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
    /// Draw measured and simulated roll, pitch and yaw into this SVG file: of several logs, those of
    /// the first. An existing file is never overwritten.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

pub(super) fn run(options: &IdentifyOptions) -> anyhow::Result<()> {
    let started = Instant::now();
    let asked = options.identification.asked()?;
    let picture = options.plot.as_deref();
    let picture = picture.map(ResultFile::reserve).transpose()?;
    let recordings = options.identification.recordings(&asked)?;
    let report = options
        .identification
        .answer(&asked, &recordings, started)?;
    if let Some(file) = picture {
        let answer = &report.identification;
        let (name, error_deg) = (&answer.description, answer.mean_error_deg);
        file.write(plot::signals(name, error_deg, &answer.signals)?)?;
    }
    let text = if options.json {
        serde_json::to_string(&report)? + "\n"
    } else {
        table(&report, &asked.robot)
    };
    output::result(&text)?;
    Ok(())
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
