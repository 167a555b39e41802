//! Logs whose truth is known, answered one after the other.

use std::path::PathBuf;

use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;

use super::{
    model_files::{AtlasFile, ModelFiles},
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
    pub(super) atlas: AtlasFile,
    #[command(flatten)]
    pub(super) search: SearchOptions,
    /// Print one JSON object instead of tables.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    pub(super) model: ModelFiles,
}

impl EvaluationOptions {
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

#[derive(Serialize, JsonSchema)]
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
