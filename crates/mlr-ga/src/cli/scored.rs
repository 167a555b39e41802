//! Logs whose truth is known, answered one after the other.

use std::path::{Path, PathBuf};

use clap::Args;
use mlr_ga::{IdentifySettings, atlas::Atlas};
use mlr_model::{Gait, Robot};
use serde::Serialize;

use super::{
    model_files::{AtlasFile, ModelFiles, OwnRobots},
    output,
    progress::Bar,
    search_options::SearchOptions,
};

/// The options of every evaluation.
#[derive(Debug, Args)]
pub(super) struct EvaluationOptions {
    /// Directories of logs, each with a truth.json that says what was done to the robots.
    #[arg(required = true, value_name = "DIR")]
    pub(super) directories: Vec<PathBuf>,
    #[command(flatten)]
    atlas: AtlasFile,
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
        if self.atlas.path().is_some() && self.own_robots.are_named() {
            anyhow::bail!("an atlas is of one robot, expected --atlas or --own-robots, not both");
        }
        self.atlas.open(robot, gait, settings)
    }

    /// The file of the atlas, if one was named.
    pub(super) fn atlas_path(&self) -> Option<&Path> {
        self.atlas.path()
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
#[derive(Serialize)]
pub(super) struct Scored<S> {
    pub(super) logs: Vec<S>,
    unanswered: Vec<Unanswered>,
}

#[derive(Serialize)]
struct Unanswered {
    log: String,
    reason: String,
}

impl<S> Scored<S> {
    /// Scores each log; one without an answer does not keep the others from theirs.
    pub(super) fn all<T>(
        truths: &[T],
        name: impl Fn(&T) -> &str,
        bar: &Bar,
        mut score: impl FnMut(&T) -> anyhow::Result<S>,
    ) -> Self {
        let mut scored = Self {
            logs: Vec::new(),
            unanswered: Vec::new(),
        };
        for truth in truths {
            match score(truth) {
                Ok(score) => scored.logs.push(score),
                Err(error) => scored.unanswered.push(Unanswered {
                    log: name(truth).to_string(),
                    reason: format!("{error:#}"),
                }),
            }
            bar.next_log();
        }
        scored
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
