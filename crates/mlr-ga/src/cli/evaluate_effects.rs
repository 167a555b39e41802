//! `mlr-ga evaluate-effects`: explanations against the truth.

use std::{path::PathBuf, time::Instant};

use clap::Args;
use mlr_ga::{
    ExplainSettings, IdentifySettings, Model, WalkStart, explain,
    scoring::{
        EffectsScore, EffectsTotal, EffectsTruth, KindsVerdict, Visibility, in_words,
        read_effects_truths,
    },
};
use mlr_imu::{Columns, read_log};
use serde::Serialize;

use super::{
    model_files,
    progress::Bar,
    scored::{EvaluationOptions, Scored},
};

/// Version of the JSON output.
const SCHEMA: &str = "mlr.effects-evaluation/1";

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
    /// All settings of the tracing, in TOML.
    #[arg(long, value_name = "FILE")]
    tracing: Option<PathBuf>,
}

#[derive(Serialize)]
struct Report {
    schema: &'static str,
    #[serde(flatten)]
    scored: Scored<EffectsScore>,
    total: EffectsTotal,
}

pub(super) fn run(options: &EvaluateEffectsOptions) -> anyhow::Result<()> {
    let identify = options.of.search.over(IdentifySettings::default());
    let tracing = model_files::tracing(options.tracing.as_deref())?.unwrap_or_default();
    let (robot, gait) = options.of.model.read()?;
    let atlas = options.of.atlas.open(&robot, &gait, &identify)?;
    let model = Model::new(&robot, &gait).with_atlas(atlas.as_ref());
    let how = ExplainSettings {
        identify: &identify,
        tracing: &tracing,
    };
    let mut truths = Vec::new();
    for directory in &options.of.directories {
        truths.extend(read_effects_truths(directory, &robot.layout())?);
    }
    if let Some(text) = &options.only {
        truths.retain(|truth| truth.log.name.contains(text));
    }
    let bar = Bar::of_logs(truths.len());
    let score = |truth: &EffectsTruth| {
        let identify = IdentifySettings {
            walk_start: match truth.motion_start_s {
                Some(start_s) if options.start_told => WalkStart::CommandedAtS(start_s),
                _ => WalkStart::FoundInRecording,
            },
            ..identify.clone()
        };
        let how = ExplainSettings {
            identify: &identify,
            ..how
        };
        score(truth, model, how)
    };
    let scored = Scored::all(&truths, |truth| &truth.log.name, &bar, score);
    bar.clear();
    let report = Report {
        schema: SCHEMA,
        total: EffectsTotal::new(&scored.logs),
        scored,
    };
    options.of.print(&report, Report::tables)
}

fn score(
    truth: &EffectsTruth,
    model: Model<'_>,
    how: ExplainSettings<'_>,
) -> anyhow::Result<EffectsScore> {
    let started = Instant::now();
    let recording = read_log(&truth.log.log, &Columns::default())?;
    let explained = explain(&recording, model, how, &())?;
    let elapsed_s = started.elapsed().as_secs_f64();
    Ok(EffectsScore::new(truth, &explained.explanation, elapsed_s))
}

impl Report {
    /// Markdown: reads well as it is, and in a document.
    fn tables(&self) -> String {
        let mut text =
            "| log | undeclared | visible | found | verdict | fitted [°] | unseen [°] | \
                        legs | unexplained |\n|:--|:--|:--|:--|:--|:--|:--|:--|:--|\n"
                .to_string();
        for score in &self.scored.logs {
            text += &row(score);
        }
        text + &self.scored.unanswered_rows() + "\n" + &total_text(&self.total)
    }
}

fn row(score: &EffectsScore) -> String {
    let or_none = |words: Vec<String>| match words.is_empty() {
        true => "none".to_string(),
        false => words.join("; "),
    };
    let truth = score.truth.iter().map(|effect| effect.in_words()).collect();
    let found = score.found.iter().map(|effect| {
        let mut words = format!("{} {}", effect.kind, in_words(&effect.parameters));
        let mut rivals: Vec<&str> = effect.rivals.iter().map(|r| r.kind.as_str()).collect();
        rivals.dedup();
        if !rivals.is_empty() {
            words += &format!(" (or {})", rivals.join(", "));
        }
        words
    });
    let yes = |value: bool| if value { "yes" } else { "no" };
    let arrow = |pick: fn(&mlr_residual::walk::StretchErrors) -> f64| {
        format!(
            "{:.2} → {:.2} → {:.2}",
            pick(&score.error_before),
            pick(&score.error_calibrated),
            pick(&score.error_after)
        )
    };
    let legs = match (score.legs_right_before, score.legs_right) {
        (true, true) => "right",
        (false, true) => "WRONG → right",
        (true, false) => "right → WRONG",
        (false, false) => "WRONG",
    };
    format!(
        "| {} | {} | {} | {} | {} | {} | {} | {legs} | {} |\n",
        score.log,
        or_none(truth),
        match score.visibility {
            Visibility::Unknown => "?",
            Visibility::Hidden => "no",
            Visibility::WithinSpread => "within spread",
            Visibility::StandsOut => "yes",
        },
        or_none(found.collect()),
        match score.verdict {
            KindsVerdict::Right => "right",
            KindsVerdict::Rival => "as a rival",
            KindsVerdict::Missed => "missed",
            KindsVerdict::Wrong => "WRONG",
            KindsVerdict::Partly => "partly",
            KindsVerdict::Unexplained => "unexplained",
        },
        arrow(|error| error.fit_deg),
        arrow(|error| error.validation_deg),
        yes(score.unexplained),
    )
}

fn total_text(total: &EffectsTotal) -> String {
    let ratio = |ratio: Option<f64>| ratio.map_or("-".into(), |ratio| format!("{ratio:.2}"));
    format!(
        "visible effects of the library   {} logs: right kind {}, as a rival {}\n\
         those beyond the spread          {} logs: right kind {}\n\
         two effects at once              {} logs: both found {}\n\
         effects of a leg, right kind     {}: on the right leg {}\n\
         invisible ones                   {} logs: right or none {}\n\
         outside the library              {} logs: unexplained {}; visible {}, of these unexplained {}\n\
         undisturbed                      {} logs: none found {}, unexplained {}\n\
         unseen error, after over before  {} (median of the visible), {} of that with the usual spread fitted\n\
         legs right                       {} before, {} after\n\
         time                             {:.0} s at most\n",
        total.visible,
        total.visible_right,
        total.visible_rival,
        total.standing_out,
        total.standing_out_right,
        total.two_effects,
        total.two_effects_found,
        total.on_a_leg,
        total.on_the_right_leg,
        total.invisible,
        total.invisible_right_or_none,
        total.outside,
        total.outside_unexplained,
        total.outside_visible,
        total.outside_visible_unexplained,
        total.undisturbed,
        total.undisturbed_none,
        total.undisturbed_unexplained,
        ratio(total.median_error_ratio),
        ratio(total.median_calibrated_ratio),
        total.legs_right[0],
        total.legs_right[1],
        total.longest_elapsed_s,
    )
}
