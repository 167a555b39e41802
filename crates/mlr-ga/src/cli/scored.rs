//! Logs whose truth is known, and what became of them.

use std::path::PathBuf;

use clap::Args;
use mlr_ga::{IdentifySettings, atlas::Atlas};
use mlr_model::{Gait, Robot};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{
    model_files::{AtlasFile, ModelFiles, OwnRobots},
    output,
    search_options::SearchOptions,
};

/// The options of every evaluation.
#[derive(Debug, Args)]
pub(super) struct EvaluationOptions {
    /// Directories of logs, each with a truth.json that says what was done to the robots.
    #[arg(required = true, value_name = "DIR")]
    pub(super) directories: Vec<PathBuf>,
    #[command(flatten)]
    pub(super) atlas: AtlasFile,
    #[command(flatten)]
    pub(super) search: SearchOptions,
    /// Print one JSON object instead of tables.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    pub(super) model: ModelFiles,
    #[command(flatten)]
    pub(super) own_robots: OwnRobots,
}

impl EvaluationOptions {
    /// The atlas, if one was named.
    pub(super) fn open_atlas(
        &self,
        robot: &Robot,
        gait: &Gait,
        settings: &IdentifySettings,
    ) -> anyhow::Result<Option<Atlas>> {
        if self.atlas.is_named() && self.own_robots.are_named() {
            anyhow::bail!("an atlas is of one robot, expected --atlas or --own-robots, not both");
        }
        self.atlas.open(robot, gait, settings)
    }

    /// Prints a report, as asked for.
    pub(super) fn print<R: Serialize>(
        &self,
        report: &R,
        tables: impl FnOnce(&R) -> String,
    ) -> anyhow::Result<()> {
        let text = if self.json {
            serde_json::to_string(report)? + "\n"
        } else {
            tables(report)
        };
        Ok(output::result(&text)?)
    }
}

/// The scores of the logs that were answered, and why the others were not.
#[derive(Serialize, JsonSchema)]
pub(super) struct Scored<S> {
    pub(super) logs: Vec<S>,
    unanswered: Vec<Unanswered>,
}

#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub(super) struct Unanswered {
    log: String,
    reason: String,
}

/// What became of one log.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Outcome<S> {
    Scored(S),
    Unanswered(Unanswered),
}

impl<S> Outcome<S> {
    /// One log without an answer does not keep the others from theirs.
    pub(super) fn of(log: &str, score: anyhow::Result<S>) -> Self {
        match score {
            Ok(score) => Self::Scored(score),
            Err(error) => Self::Unanswered(Unanswered {
                log: log.into(),
                reason: format!("{error:#}"),
            }),
        }
    }
}

impl<S> Scored<S> {
    /// What became of all logs, in their order.
    pub(super) fn new(outcomes: impl Iterator<Item = Outcome<S>>) -> Self {
        let (mut logs, mut unanswered) = (Vec::new(), Vec::new());
        for outcome in outcomes {
            match outcome {
                Outcome::Scored(score) => logs.push(score),
                Outcome::Unanswered(log) => unanswered.push(log),
            }
        }
        Self { logs, unanswered }
    }

    /// How many logs have no answer.
    pub(super) fn unanswered(&self) -> usize {
        self.unanswered.len()
    }

    /// A row of a Markdown table for each log without an answer.
    pub(super) fn unanswered_rows(&self) -> String {
        let rows = self.unanswered.iter();
        rows.map(|row| format!("| {} | no answer: {} |\n", row.log, row.reason))
            .collect()
    }
}
