//! `mlr-ga evaluate-discrepancy`: what the model leaves of robots that lack nothing.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use clap::Args;
use mlr_ga::{
    EvidenceSettings, IdentifySettings, MeasuredWalk, Model, explanation_settings,
    scoring::{EffectsTruth, TrueEffect, read_effects_truths},
    walk_record,
};
use mlr_imu::{Columns, read_log};
use mlr_model::{Gait, LostLinks, Robot};
use mlr_residual::{
    walk::{CalibratedWalk, KnownEffect, KnownRobot, LOCKED_LINKS, Simulated, WalkModel},
    walk_effects,
};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::{
    model_files::{ModelFiles, OwnRobots},
    output::{self, ResultFile},
    progress::Bar,
};

/// Version of the JSON output.
const SCHEMA: &str = "mlr.discrepancy/1";

#[derive(Debug, Args)]
pub(super) struct EvaluateDiscrepancyOptions {
    /// Directories of logs with a truth.json. Robots with effects that the library lacks, or that it looks for only
    /// where the start of the walk is known, are left out.
    #[arg(required = true, value_name = "DIR")]
    directories: Vec<PathBuf>,
    /// Write residuals and sensitivities of every walk as JSON, for tools/plant/discrepancy.py. An
    /// existing file is never overwritten.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Take the mean of many walks about the most probable parameters in place of a single one.
    #[arg(long)]
    means: bool,
    /// All settings of the explanation, in TOML.
    #[arg(long, value_name = "FILE")]
    explanation: Option<PathBuf>,
    #[command(flatten)]
    model: ModelFiles,
    #[command(flatten)]
    own_robots: OwnRobots,
}

#[derive(Serialize, JsonSchema)]
pub(super) struct Report {
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    walks: Vec<Walk>,
}

#[derive(Serialize, JsonSchema)]
struct Walk {
    log: String,
    morphology: String,
    locked: bool,
    /// The kinds of its effects.
    effects: Vec<String>,
    #[serde(flatten)]
    walk: CalibratedWalk,
}

pub(super) fn run(options: &EvaluateDiscrepancyOptions) -> anyhow::Result<()> {
    let settings = explanation_settings(options.explanation.as_deref())?.unwrap_or_default();
    let (robot, gait) = options.model.read()?;
    let file = options.output.as_deref();
    let file = file.map(ResultFile::reserve).transpose()?;
    let mut truths = Vec::new();
    for directory in &options.directories {
        truths.extend(read_effects_truths(directory, &robot.layout())?);
    }
    truths.retain(|truth| truth.effects.iter().all(can_be_fitted));
    let generator = ChaCha8Rng::seed_from_u64(0);
    let simulated = match options.means {
        true => Simulated::Mean(&generator),
        false => Simulated::Once,
    };
    let bar = Bar::of_logs(truths.len());
    let walks = truths
        .par_iter()
        .map(|truth| {
            let own = options.own_robots.of(&truth.log.name)?;
            let robot = own.as_ref().unwrap_or(&robot);
            let walk = calibrated(truth, robot, &gait, simulated, &settings);
            mlr_residual::Progress::advance(&bar);
            walk.with_context(|| truth.log.log.display().to_string())
        })
        .collect::<anyhow::Result<Vec<Option<Walk>>>>()?;
    bar.clear();
    let report = Report {
        schema: SCHEMA,
        walks: walks.into_iter().flatten().collect(),
    };
    if let Some(file) = file {
        file.write(&(serde_json::to_string(&report)? + "\n"))?;
    }
    Ok(output::result(&report.table())?)
}

/// `None` where the simulated robot does not walk.
fn calibrated(
    truth: &EffectsTruth,
    robot: &Robot,
    gait: &Gait,
    simulated: Simulated<'_>,
    settings: &EvidenceSettings,
) -> anyhow::Result<Option<Walk>> {
    let recording = read_log(&truth.log.log, &Columns::default())?;
    let identify = IdentifySettings::default();
    let start_s = MeasuredWalk::new(&recording, gait, &identify)?
        .start()
        .start_s;
    // These robots were damaged before they walked.
    let from_the_start = IdentifySettings {
        from_s: Some(start_s),
        ..identify
    };
    let record = walk_record(
        &recording,
        Model::new(robot, gait),
        &from_the_start,
        &settings.nuisance,
    )?;
    let lost_links = match truth.locked {
        true => LostLinks::Locked,
        false => LostLinks::Absent,
    };
    let simulation = from_the_start.simulation;
    let nominal = WalkModel::of_make(robot.clone(), gait.clone(), simulation, &settings.nuisance);
    let morphology = &truth.log.morphology;
    let effects = truth.effects.iter().filter(|one| one.kind != LOCKED_LINKS);
    let known = KnownRobot {
        morphology,
        lost_links,
        effects: effects.map(known_effect).collect(),
    };
    let walk = CalibratedWalk::new(&record, &nominal, &known, simulated, settings)?;
    let effects = known.effects.into_iter().map(|one| one.kind);
    Ok(walk.map(|walk| Walk {
        log: name(&truth.log.log),
        morphology: morphology.to_string(),
        locked: truth.locked,
        effects: effects.collect(),
        walk,
    }))
}

fn can_be_fitted(effect: &TrueEffect) -> bool {
    effect.kind == LOCKED_LINKS
        || walk_effects::find(&effect.kind).is_some_and(|effect| !effect.is_a_delay())
}

fn known_effect(effect: &TrueEffect) -> KnownEffect {
    let number = |name: &str| {
        let number = effect.parameters.get(name)?.as_u64()?;
        usize::try_from(number).ok()
    };
    KnownEffect {
        kind: effect.kind.clone(),
        leg: number("leg"),
        part: number("joint").or_else(|| number("link")),
    }
}

fn name(log: &Path) -> String {
    log.display().to_string()
}

impl Report {
    /// One line for each walk, the steadiest first.
    fn table(&self) -> String {
        let mut walks: Vec<&Walk> = self.walks.iter().collect();
        walks.sort_by(|a, b| a.walk.spread_deg.total_cmp(&b.walk.spread_deg));
        let mut text = "| log | morphology | lost links | effects | swing [°] | spread [°] | \
                        roll, pitch, yaw left [°] | ln evidence | by something unknown |\n\
                        |:--|:--|:--|:--|--:|--:|:--|--:|--:|\n"
            .to_string();
        for Walk {
            log,
            morphology,
            locked,
            effects,
            walk,
        } in walks
        {
            let walking = walk
                .walked_s
                .iter()
                .filter(|walked_s| **walked_s <= 0.0)
                .count();
            let left = walk
                .residual_deg
                .each_ref()
                .map(|axis| deviation(&axis[walking..]));
            text += &format!(
                "| {log} | {morphology} | {} | {} | {:.2} | {:.2} | {:.2}, {:.2}, {:.2} | {:.1} | {} |\n",
                if *locked { "locked" } else { "gone" },
                effects.join(", "),
                walk.swing_deg,
                walk.spread_deg,
                left[0],
                left[1],
                left[2],
                walk.ln_evidence,
                walk.ln_gain_of_unknown
                    .map_or_else(String::new, |ln_gain| format!("{ln_gain:+.1}")),
            );
        }
        text
    }
}

/// About the mean.
fn deviation(values: &[f64]) -> f64 {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt()
}
