//! `mlr-ga evaluate-effects`: explanations against the truth.

use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use clap::Args;
use mlr_ga::{
    ExplainSettings, IdentifySettings, Model, Progress, WalkStart, explain, explanation_settings,
    scoring::{
        EffectsScore, EffectsTotal, EffectsTruth, Origin, UnansweredLog, read_effects_truths,
    },
};
use mlr_imu::{Columns, read_log};
use mlr_model::Robot;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::{
    effects_tables::tables,
    kept_results::{Job, KeptResults},
    progress::Bar,
    resume::{LogIdentity, RunIdentity, checksum, checksum_of_file},
    scored::EvaluationOptions,
    side_by_side::side_by_side,
};

/// Version of the JSON output.
const SCHEMA: &str = "mlr.effects-evaluation/2";

#[derive(Debug, Args)]
pub(super) struct EvaluateEffectsOptions {
    #[command(flatten)]
    of: EvaluationOptions,
    /// Only logs whose names contain this.
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Tell when each walk was commanded, as `explain --start-s` does: delays show only then.
    #[arg(long)]
    start_told: bool,
    /// All settings of the explanation, in TOML.
    #[arg(long, value_name = "FILE")]
    explanation: Option<PathBuf>,
    #[command(flatten)]
    kept: KeptResults,
}

/// What became of the logs.
#[derive(Serialize, JsonSchema)]
pub(super) struct Report {
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    pub(super) logs: Vec<EffectsScore>,
    pub(super) unanswered: Vec<UnansweredLog>,
    /// Logs of each origin apart.
    pub(super) totals: Vec<EffectsTotal>,
}

/// What became of one log.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Outcome {
    Scored(Box<EffectsScore>),
    Unanswered(UnansweredLog),
}

/// An outcome as it is kept, with the whole explanation for whoever wants to know more.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Kept {
    outcome: Outcome,
    explanation: Value,
}

/// A log that is to be explained.
struct EffectsJob {
    directory: PathBuf,
    truth: EffectsTruth,
    /// The robot of this log alone, where it is not that of all.
    robot: Option<Robot>,
}

pub(super) fn run(options: &EvaluateEffectsOptions) -> anyhow::Result<()> {
    let identify = options.of.search.overrides();
    let identify = identify.over(IdentifySettings::default())?;
    let explanation = explanation_settings(options.explanation.as_deref())?.unwrap_or_default();
    let (robot, gait) = options.of.model.read()?;
    let atlas = options.of.open_atlas(&robot, &gait, &identify)?;
    let model = Model::new(&robot, &gait).with_atlas(atlas.as_ref());
    let how = ExplainSettings {
        identify: &identify,
        explanation: &explanation,
    };
    let jobs = jobs(options, model)?;
    let run = options
        .kept
        .are_wanted()
        .then(|| run_identity(options, model, how));
    let bar = Bar::of_logs(0);
    let outcomes = options.kept.of_all(
        &jobs,
        run.transpose()?.as_ref(),
        |open, answer| {
            bar.expect(open.len());
            side_by_side(open, answer)
        },
        |job: &EffectsJob| {
            let kept = job.outcome(model, how, options.start_told);
            bar.next_log();
            kept
        },
    );
    bar.clear();
    let Some(outcomes) = outcomes? else {
        return Ok(());
    };
    let outcomes = outcomes.into_iter().zip(&jobs).map(|(kept, job)| {
        let several = (options.of.directories.len() > 1).then_some(job.directory.as_path());
        kept.outcome.named(several)
    });
    options.of.print(&Report::new(outcomes), tables)
}

/// The logs of all directories.
fn jobs(options: &EvaluateEffectsOptions, model: Model<'_>) -> anyhow::Result<Vec<EffectsJob>> {
    let mut jobs = Vec::new();
    for directory in &options.of.directories {
        let truths = read_effects_truths(directory, &model.robot.layout())?;
        let only = options.only.as_deref().unwrap_or("");
        for truth in truths {
            if truth.log.name.contains(only) {
                jobs.push(EffectsJob {
                    directory: directory.clone(),
                    robot: options.of.own_robots.of(&truth.log.name)?,
                    truth,
                });
            }
        }
    }
    Ok(jobs)
}

/// Everything that results depend on beside the logs.
fn run_identity(
    options: &EvaluateEffectsOptions,
    model: Model<'_>,
    how: ExplainSettings<'_>,
) -> anyhow::Result<RunIdentity> {
    let atlas = options.of.atlas.checksum()?;
    Ok(RunIdentity::new(json!({
        "start_told": options.start_told,
        // Not among the settings, because it comes with each call.
        "seed": how.identify.seed,
        "identification": how.identify,
        "explanation": how.explanation,
        "robot": checksum(&format!("{:?}", model.robot)),
        "gait": checksum(&format!("{:?}", model.gait)),
        "atlas": atlas,
    })))
}

impl Job for EffectsJob {
    fn name(&self) -> String {
        self.directory
            .join(&self.truth.log.name)
            .display()
            .to_string()
    }

    fn identity(&self) -> Option<LogIdentity> {
        let EffectsTruth {
            log,
            locked,
            effects,
            motion_start_s,
            trace,
            origin,
        } = &self.truth;
        let of_log = checksum_of_file(&log.log).ok()?;
        let truth = (
            &log.morphology,
            locked,
            effects,
            motion_start_s,
            trace,
            origin,
        );
        let known = format!("{truth:?} {:?}", self.robot);
        Some(LogIdentity {
            directory: self.directory.clone(),
            log: log.name.clone(),
            checksum: checksum(&format!("{of_log} {known}")),
        })
    }
}

impl EffectsJob {
    /// Explains the log and scores the answer.
    fn outcome(
        &self,
        model: Model<'_>,
        how: ExplainSettings<'_>,
        start_told: bool,
    ) -> anyhow::Result<Kept> {
        let Self { truth, robot, .. } = self;
        let model = match robot {
            Some(robot) => Model::new(robot, model.gait),
            None => model,
        };
        let identify = IdentifySettings {
            walk_start: match truth.motion_start_s {
                Some(start_s) if start_told => WalkStart::CommandedAtS(start_s),
                _ => WalkStart::FoundInRecording,
            },
            ..how.identify.clone()
        };
        let how = ExplainSettings {
            identify: &identify,
            ..how
        };
        let started = Instant::now();
        let answer = || {
            let recording = read_log(&truth.log.log, &Columns::default())?;
            Ok::<_, anyhow::Error>(explain(&recording, model, how, &())?.explanation)
        };
        Ok(match answer() {
            Ok(explanation) => {
                let elapsed_s = started.elapsed().as_secs_f64();
                let score = EffectsScore::new(truth, &explanation, start_told, elapsed_s);
                Kept {
                    outcome: Outcome::Scored(Box::new(score)),
                    explanation: serde_json::to_value(&explanation)?,
                }
            }
            // One log without an answer does not keep the others from theirs.
            Err(error) => Kept {
                outcome: Outcome::Unanswered(UnansweredLog::new(
                    truth,
                    start_told,
                    format!("{error:#}"),
                )),
                explanation: Value::Null,
            },
        })
    }
}

impl Outcome {
    /// Puts the directory before the log's name, where logs of several may have one name.
    fn named(mut self, directory: Option<&Path>) -> Self {
        let log = match &mut self {
            Self::Scored(score) => &mut score.log,
            Self::Unanswered(log) => &mut log.log,
        };
        if let Some(folder) = directory.and_then(Path::file_name) {
            *log = format!("{}/{log}", folder.display());
        }
        self
    }
}

impl Report {
    fn new(outcomes: impl Iterator<Item = Outcome>) -> Self {
        let (mut logs, mut unanswered) = (Vec::new(), Vec::new());
        for outcome in outcomes {
            match outcome {
                Outcome::Scored(score) => logs.push(*score),
                Outcome::Unanswered(log) => unanswered.push(log),
            }
        }
        let totals = [Origin::Drawn, Origin::StandIn]
            .into_iter()
            .filter_map(|origin| EffectsTotal::new(origin, &logs, &unanswered));
        Self {
            schema: SCHEMA,
            totals: totals.collect(),
            logs,
            unanswered,
        }
    }
}
