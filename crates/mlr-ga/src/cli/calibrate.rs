//! `mlr-ga calibrate`.

use std::path::{Path, PathBuf};

use clap::Args;
use mlr_filter::SettingError;
use mlr_ga::{
    CalibrationReport, Configuration, ExplainSettings, HealthyWalk, WalkOrigin, calibrate,
};
use mlr_model::Measurement;

use super::{
    log_file::{self, LogFiles},
    model_files::ModelOfLogs,
    output::{self, ResultFile},
    progress::Bar,
};

#[derive(Debug, Args)]
pub(super) struct CalibrateOptions {
    #[command(flatten)]
    logs: LogFiles,
    #[command(flatten)]
    model: ModelOfLogs,
    /// Write the robot's description with its own numbers to this file. An existing file is never
    /// overwritten.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Do not look for damage and effects first: take the word of who recorded the logs that nothing
    /// was wrong with the robot.
    #[arg(long)]
    healthy: bool,
    /// A number of the robot that was measured on a bench, with the standard deviation of the measurement:
    /// NAME=VALUE+-DEVIATION in the unit of the description, as in body_mass=1.412+-0.005; may be
    /// repeated. Names are those of the table.
    #[arg(long, value_name = "MEASUREMENT")]
    measured: Vec<String>,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
    /// All settings, in TOML, such as the daemon's /etc/mlrd.toml.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

pub(super) fn run(options: &CalibrateOptions) -> anyhow::Result<()> {
    let Configuration {
        identification,
        explanation,
        mounting,
        ..
    } = Configuration::read(options.config.as_deref(), None)?;
    let paths = options.logs.paths();
    let (robot, text, gaits) = options.model.read(paths.len())?;
    let measured = options.measured.iter().map(|text| Measurement::parse(text));
    let measured: Vec<Measurement> = measured.collect::<Result<_, _>>().map_err(as_option)?;
    let make = &explanation.nuisance;
    let known = measured.iter().try_fold(robot.clone(), |robot, one| {
        robot.measured(one, |parameter| make.of_make(parameter))
    });
    let known = known.map_err(as_option)?;
    let file = ResultFile::reserve(&options.output)?;
    let recordings = options.logs.read(&mounting)?;
    let both = recordings.iter().zip(&gaits);
    let walks: Vec<HealthyWalk<'_>> = both
        .map(|(recording, gait)| HealthyWalk { recording, gait })
        .collect();
    let settings = ExplainSettings {
        identify: &identification,
        explanation: &explanation,
    };
    let bar = Bar::of_steps();
    let found = calibrate(&walks, &known, settings, !options.healthy, &bar);
    bar.clear();
    let found = found.map_err(|(index, error)| {
        let of_the_log = error.is_recordings_fault();
        options.logs.blame_if(index, of_the_log, error.into())
    })?;
    let origins = paths.iter().zip(&gaits).map(|(path, gait)| {
        Ok(WalkOrigin {
            log: path.display().to_string(),
            sha256: log_file::sha256(path)?.unwrap_or_default(),
            gait: gait.name.clone(),
        })
    });
    let origins = origins.collect::<anyhow::Result<Vec<WalkOrigin>>>()?;
    let report = CalibrationReport::new(&robot, &found, &explanation.nuisance, origins);
    let report = report.with_measured(&measured);
    file.write(&report.description(&text, &found.robot)?)?;
    for warning in &report.warnings {
        output::warning(warning);
    }
    let text = match options.json {
        true => serde_json::to_string(&report)? + "\n",
        false => table(&report, &options.output),
    };
    Ok(output::result(&text)?)
}

fn as_option(error: SettingError) -> SettingError {
    error.as_option(&[("measured", "--measured")])
}

/// The report for people.
fn table(report: &CalibrationReport, file: &Path) -> String {
    let mut table = output::Table::default();
    table.line("robot", file.display());
    let axes = |errors: [f64; 3]| errors.map(|error| format!("{error:6.2}°")).join(" ");
    table.line(
        "unseen error",
        "   roll   pitch     yaw   before, then calibrated",
    );
    for walk in &report.walks {
        table.line(
            "",
            format!(
                "{}, {}  {}",
                axes(walk.error_before.validation_axes_deg),
                axes(walk.error_after.validation_axes_deg),
                walk.origin.log
            ),
        );
    }
    let after = |walk: usize| format!("  after {:>2}", walk + 1);
    let heads: String = (0..report.walks.len()).map(after).collect();
    table.line(
        "",
        format!(
            "{:<18} {:>4}   changed  the robot's own ±: make{heads}",
            "", ""
        ),
    );
    let lines = report.parameters.iter().map(|one| {
        let after = one.physical_deviations.iter();
        format!(
            "{:<18} {:>4} {:9.4} {:9.4}      {:8.4}{}{}",
            one.name,
            one.unit,
            one.fitted - one.described,
            one.physical - one.described,
            one.make_deviation,
            after.map(|one| format!(" {one:9.4}")).collect::<String>(),
            if one.is_told { "" } else { "  not told" }
        )
    });
    table.lines("", lines);
    table.into_text()
}
