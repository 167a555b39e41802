//! `mlr-ga evaluate`: answers against the truth.

use std::{path::PathBuf, time::Instant};

use clap::Args;
use mlr_ga::{
    Configuration, IdentifyOverrides, IdentifySettings, Method, Model, Progress, Search, identify,
    scoring::{LogScore, TotalScore, Truth, read_truths},
};
use mlr_imu::{Columns, Recording, read_log};
use mlr_model::Robot;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::json;

use super::{
    kept_results::{Job, KeptResults},
    model_files::MethodName,
    progress::Bar,
    resume::{LogIdentity, RunIdentity, checksum, checksum_of_file},
    scored::{EvaluationOptions, Outcome, Scored},
};

/// Version of the JSON output.
const SCHEMA: &str = "mlr.evaluation/1";

#[derive(Debug, Args)]
pub(super) struct EvaluateOptions {
    #[command(flatten)]
    of: EvaluationOptions,
    #[command(flatten)]
    kept: KeptResults,
    /// What decides [default: mlr].
    #[arg(long, value_enum)]
    method: Option<MethodName>,
    /// Length of the compared stretch [default: 5 s].
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    window_s: Option<f64>,
    /// All settings, in TOML.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

#[derive(Serialize, JsonSchema)]
pub(super) struct Report {
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    method: Method,
    search: Search,
    directories: Vec<DirectoryReport>,
    total: TotalScore,
}

#[derive(Serialize, JsonSchema)]
struct DirectoryReport {
    directory: PathBuf,
    #[serde(flatten)]
    scored: Scored<LogScore>,
    total: TotalScore,
}

/// A log that is to be scored.
struct ScoreJob {
    directory: PathBuf,
    truth: Truth,
    /// The robot of this log alone, where it is not that of all.
    robot: Option<Robot>,
}

impl Job for ScoreJob {
    fn name(&self) -> String {
        self.directory.join(&self.truth.name).display().to_string()
    }

    fn identity(&self) -> Option<LogIdentity> {
        let Truth {
            name,
            log,
            morphology,
        } = &self.truth;
        let of_log = checksum_of_file(log).ok()?;
        Some(LogIdentity {
            directory: self.directory.clone(),
            log: name.clone(),
            checksum: checksum(&format!("{of_log} {morphology} {:?}", self.robot)),
        })
    }
}

pub(super) fn run(options: &EvaluateOptions) -> anyhow::Result<()> {
    let Configuration {
        identification,
        mounting,
        ..
    } = Configuration::read(options.config.as_deref(), options.method.map(Method::from))?;
    let overrides = IdentifyOverrides {
        window_s: options.window_s,
        ..options.of.search.overrides()
    };
    let settings = overrides.over(identification);
    let settings = settings.map_err(|error| error.as_option(&[("window_s", "--window-s")]))?;
    let (robot, gait) = options.of.model.read()?;
    settings.check_on(&robot)?;
    let atlas = options.of.open_atlas(&robot, &gait, &settings)?;
    let model = Model::new(&robot, &gait).with_atlas(atlas.as_ref());
    let layout = robot.layout();
    let mut jobs = Vec::new();
    for directory in &options.of.directories {
        let truths = read_truths(directory, &layout)?;
        for truth in truths {
            jobs.push(ScoreJob {
                directory: directory.clone(),
                robot: options.of.own_robots.of(&truth.name)?,
                truth,
            });
        }
    }
    let run = options.kept.are_wanted().then(|| {
        Ok::<_, anyhow::Error>(RunIdentity::new(json!({
            // Not among the settings, because it comes with each call.
            "seed": settings.seed,
            "identification": settings,
            "mounting": mounting,
            "robot": checksum(&format!("{robot:?}")),
            "gait": checksum(&format!("{gait:?}")),
            "atlas": options.of.atlas.checksum()?,
        })))
    });
    let bar = Bar::of_logs(0);
    let outcomes = options.kept.of_all(
        &jobs,
        run.transpose()?.as_ref(),
        |open, answer| {
            bar.expect(open.len());
            open.iter().map(answer).collect()
        },
        |job: &ScoreJob| {
            let score = || {
                let recording =
                    read_log(&job.truth.log, &Columns::default())?.mounted(&mounting)?;
                let model = match &job.robot {
                    Some(robot) => Model::new(robot, &gait),
                    None => model,
                };
                score(&job.truth, &recording, model, &settings)
            };
            let outcome = Outcome::of(&job.truth.name, score());
            bar.next_log();
            Ok(outcome)
        },
    );
    bar.clear();
    let Some(outcomes) = outcomes? else {
        return Ok(());
    };
    let mut outcomes = jobs.iter().zip(outcomes).peekable();
    let reports = options.of.directories.iter().map(|directory| {
        let is_in = |(job, _): &(&ScoreJob, _)| job.directory == *directory;
        let of_directory = std::iter::from_fn(|| outcomes.next_if(is_in));
        let scored = Scored::new(of_directory.map(|(_, outcome)| outcome));
        DirectoryReport {
            total: TotalScore::new(&scored.logs, scored.unanswered(), &gait),
            directory: directory.clone(),
            scored,
        }
    });
    let reports: Vec<DirectoryReport> = reports.collect();
    let all: Vec<LogScore> = reports
        .iter()
        .flat_map(|report| report.scored.logs.clone())
        .collect();
    let unanswered = reports
        .iter()
        .map(|report| report.scored.unanswered())
        .sum();
    let report = Report {
        schema: SCHEMA,
        method: settings.method,
        search: settings.search_with(atlas.is_some()),
        directories: reports,
        total: TotalScore::new(&all, unanswered, &gait),
    };
    options.of.print(&report, Report::tables)
}

fn score(
    truth: &Truth,
    recording: &Recording,
    model: Model<'_>,
    settings: &IdentifySettings,
) -> anyhow::Result<LogScore> {
    let started = Instant::now();
    let answer = identify(recording, model, settings, &())?;
    Ok(LogScore::new(
        truth,
        &answer,
        started.elapsed().as_secs_f64(),
    ))
}

impl Report {
    /// Markdown: reads well as it is, and in a document.
    fn tables(&self) -> String {
        let mut text = String::new();
        for report in &self.directories {
            text += &report.table();
        }
        if self.directories.len() > 1 {
            text += "All directories:\n\n";
        }
        text + &total_table(&self.total)
    }
}

impl DirectoryReport {
    fn table(&self) -> String {
        let mut text = format!(
            "{}\n\n| log | truth | answer | legs | links | sure | listed | time [s] |\n\
             |:--|:--|:--|:--|:--|--:|--:|--:|\n",
            self.directory.display()
        );
        for score in &self.scored.logs {
            let [truth, answer] = score.in_words();
            text += &format!(
                "| {} | {truth} | {answer} | {} | {} | {:.0} % | {} | {:.1} |\n",
                score.log,
                mark(score.legs_right),
                if score.links_right {
                    "right"
                } else if score.covered {
                    "listed"
                } else {
                    "WRONG"
                },
                100.0 * score.confidence,
                score.listed,
                score.elapsed_s,
            );
        }
        text + &self.scored.unanswered_rows() + "\n"
    }
}

fn total_table(total: &TotalScore) -> String {
    let mut text = format!(
        "legs right     {} of {}\nlinks right    {}\ntruth listed   {}\n\
             listed         {} (median)\nBrier score    {:.4}\n\
             time           {:.1} s on average, {:.1} s at most\n",
        total.legs_right,
        total.answered + total.unanswered,
        total.links_right,
        total.covered,
        total.median_listed,
        total.brier,
        total.mean_elapsed_s,
        total.longest_elapsed_s,
    );
    text += "\n| confidence | answers | mean confidence | legs right |\n|:--|--:|--:|--:|\n";
    for row in &total.calibration {
        text += &format!(
            "| {:.0} to {:.0} % | {} | {:.1} % | {:.0} % |\n",
            100.0 * row.confidence[0],
            100.0 * row.confidence[1],
            row.answers,
            100.0 * row.mean_confidence,
            100.0 * row.legs_right_share,
        );
    }
    text += "\n| damaged legs per group | answered as | logs | legs right |\n|:--|:--|--:|--:|\n";
    for row in &total.confusion {
        text += &format!(
            "| {} | {} | {} | {} |\n",
            row.truth, row.answer, row.count, row.legs_right
        );
    }
    text
}

fn mark(right: bool) -> &'static str {
    if right { "right" } else { "WRONG" }
}
