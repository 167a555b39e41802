//! `mlr-ga explain`.

use std::{path::PathBuf, time::Instant};

use clap::Args;
use mlr_ga::{
    Configuration, ExplainSettings, ExplanationReport, IdentifyOverrides, Model,
    earlier_effects_of_json, explain_after, explanation_settings,
};
use mlr_model::Robot;
use mlr_residual::walk::{StretchErrors, TracedEffect};

use super::{
    log_file::LogFile,
    model_files::{AtlasFile, ModelFiles},
    output::{self, ResultFile},
    progress::Bar,
    saved_answer::saved_answer,
    search_options::SearchOptions,
};

/// Kinds of effects that are shown to people, and the least probability of one.
const SHOWN: usize = 6;
const LEAST_SHOWN: f64 = 0.005;

#[derive(Debug, Args)]
pub(super) struct ExplainOptions {
    #[command(flatten)]
    log: LogFile,
    #[command(flatten)]
    search: SearchOptions,
    /// Log time at which the robot was commanded to walk, where that is known: a delay of servos or
    /// sensor shows only then.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    start_s: Option<f64>,
    /// What explain found in an earlier log of this robot on the same day, as it printed it with --json: which
    /// effects are there is then a matter of both logs.
    #[arg(long, value_name = "FILE")]
    after: Option<PathBuf>,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
    /// Write the JSON object to this file too. An existing file is never overwritten.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// All settings, in TOML, such as the daemon's /etc/mlrd.toml.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// All settings of the explanation, in TOML, instead of those of --config.
    #[arg(long, value_name = "FILE")]
    explanation: Option<PathBuf>,
    #[command(flatten)]
    atlas: AtlasFile,
    #[command(flatten)]
    model: ModelFiles,
}

pub(super) fn run(options: &ExplainOptions) -> anyhow::Result<()> {
    let started = Instant::now();
    let Configuration {
        identification,
        explanation,
        mounting,
        ..
    } = Configuration::read(options.config.as_deref(), None)?;
    let overrides = IdentifyOverrides {
        start_s: options.start_s,
        ..options.search.overrides()
    };
    let settings = overrides.over(identification);
    let settings = settings.map_err(|error| error.as_option(&[("start_s", "--start-s")]))?;
    let explanation = explanation_settings(options.explanation.as_deref())?.unwrap_or(explanation);
    let (robot, gait) = options.model.read()?;
    settings.check_on(&robot)?;
    let earlier = options
        .after
        .as_deref()
        .map(|path| saved_answer(path, |text| earlier_effects_of_json(text, &robot)));
    let earlier = earlier.transpose()?;
    let file = options.output.as_deref();
    let file = file.map(ResultFile::reserve).transpose()?;
    let recording = options.log.read()?.mounted(&mounting)?;
    let atlas = options.atlas.open(&robot, &gait, &settings)?;
    let model = Model::new(&robot, &gait).with_atlas(atlas.as_ref());
    let how = ExplainSettings {
        identify: &settings,
        explanation: &explanation,
    };
    let bar = Bar::of_steps();
    let answer = explain_after(earlier.as_ref(), &recording, model, how, &bar);
    bar.clear();
    let explained = answer.map_err(|error| {
        let of_the_log = error.is_recordings_fault();
        options.log.blame_if(of_the_log, error.into())
    })?;
    let warnings = explained.identification.warnings.iter();
    for warning in warnings.chain(&explained.explanation.warnings) {
        output::warning(warning);
    }
    let report = ExplanationReport::of(
        options.log.path().display().to_string(),
        settings.seed,
        explained,
        started.elapsed(),
    );
    let json = serde_json::to_string(&report)? + "\n";
    if let Some(file) = file {
        file.write(&json)?;
    }
    let text = if options.json {
        json
    } else {
        table(&report, &robot)
    };
    Ok(output::result(&text)?)
}

/// The answer for people.
fn table(report: &ExplanationReport, robot: &Robot) -> String {
    let found = &report.explanation;
    let mut table = output::Table::default();
    table.line("log", &report.log);
    if found.morphology == found.morphology_before {
        table.line("morphology", &found.morphology);
    } else {
        table.line("morphology", &found.morphology_before);
        table.line(
            "",
            format!("{}  with the effects in place", found.morphology),
        );
    }
    table.line("legs damaged", legs(&found.damaged_legs, robot));
    if let Some([from_s, to_s]) = report.calibrated_on_s {
        let walk = format!("by its walk before the damage, {from_s:.1} s to {to_s:.1} s");
        table.line("robot known", walk);
    }
    let length = |[from_s, to_s]: [f64; 2]| to_s - from_s;
    let stretches = &found.stretches_s;
    table.line(
        "RMS error",
        format!(
            "fitted {:.1} s: all   roll  pitch    yaw   unseen {:.1} s: all   roll  pitch    yaw",
            length(stretches.fit),
            length(stretches.validation)
        ),
    );
    table.line("as described", errors(&found.error_before));
    table.line("calibrated", errors(&found.error_calibrated));
    table.line("with effects", errors(&found.error_after));
    let mut kinds: Vec<(&String, &f64)> = found.effect_probability.iter().collect();
    kinds.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    let shown = kinds
        .into_iter()
        .take(SHOWN)
        .filter(|(_, p)| **p >= LEAST_SHOWN);
    table.lines(
        "probable",
        shown.map(|(kind, p)| format!("{:>5.1} %  {kind}", 100.0 * p)),
    );
    if found.effects.is_empty() {
        table.line(
            "effects",
            "none: the model lacks nothing that the log tells",
        );
    }
    table.lines("effects", found.effects.iter().map(effect_text));
    let residual = &found.residual;
    table.line(
        "remains",
        format!(
            "{:.2}° of {}, usual {:.2}°: {}",
            residual.remaining_deg, residual.axis, residual.usual_deg, residual.explains
        ),
    );
    if let (Some(frequency_hz), Some(amplitude_deg)) =
        (residual.frequency_hz, residual.amplitude_deg)
    {
        table.line(
            "",
            format!(
                "strongest at {frequency_hz:.2} Hz with {amplitude_deg:.2}°, {} step with the gait{}",
                if residual.locked_to_gait { "in" } else { "out of" },
                residual
                    .body_torque_nm
                    .map_or(String::new(), |t| format!("; {t:.2} N m on the free body")),
            ),
        );
    }
    table.line("unexplained", if found.unexplained { "yes" } else { "no" });
    table.line("time", format!("{:.1} s", report.elapsed_s));
    table.into_text()
}

fn legs(numbers: &[usize], robot: &Robot) -> String {
    if numbers.is_empty() {
        return "none".into();
    }
    let named = numbers.iter().map(|&number| robot.numbered_name(number));
    named.collect::<Vec<_>>().join(", ")
}

fn errors(error: &StretchErrors) -> String {
    let stretch = |all: f64, axes: [f64; 3]| {
        let [roll, pitch, yaw] = axes;
        format!("{all:>6.2}° {roll:>5.2}° {pitch:>5.2}° {yaw:>5.2}°")
    };
    format!(
        "            {}               {}",
        stretch(error.fit_deg, error.fit_axes_deg),
        stretch(error.validation_deg, error.validation_axes_deg)
    )
}

fn effect_text(effect: &TracedEffect) -> String {
    let parameters = effect.parameters.iter().map(|(name, value)| {
        let interval = effect
            .interval_95
            .get(name)
            .map_or(String::new(), |[low, high]| {
                format!(" ({low:.3} to {high:.3})")
            });
        format!("{name} {value}{interval}")
    });
    let parameters: Vec<String> = parameters.collect();
    let mut text = format!("{}: {}", effect.kind, parameters.join(", "));
    if !effect.undetermined.is_empty() {
        text += &format!("; not determined: {}", effect.undetermined.join(", "));
    }
    if !effect.at_bound.is_empty() {
        text += &format!("; at its bound: {}", effect.at_bound.join(", "));
    }
    if !effect.rivals.is_empty() {
        let mut kinds: Vec<&str> = effect.rivals.iter().map(|r| r.kind.as_str()).collect();
        kinds.dedup();
        text += &format!("; or {}", kinds.join(", "));
    }
    text
}
