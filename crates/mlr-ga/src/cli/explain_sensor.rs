//! `mlr-ga explain-sensor`.

use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use clap::Args;
use mlr_imu::read_text;
use mlr_residual::{
    AngleUnit, Effect, ErrorDeg, RateUnit, SelectionSettings, SensorColumns, SensorError,
    SensorExplanation, SensorLog, SensorRecord, TimeUnit, Transfer, apply_effects, explain_sensor,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{log_file::TableOptions, output};

/// Version of the JSON output.
const SCHEMA: &str = "mlr.sensor_explanation/1";
/// The most that is read of an earlier report.
const MAX_REPORT_BYTES: u64 = 10_000_000;

#[derive(Debug, Args)]
pub(super) struct ExplainSensorOptions {
    /// The log: .csv or .csv.gz with the columns named by --time, --rate and --angle. Other rates,
    /// accelerations and the temperature of the same sensor are found by their names: g2y_dps,
    /// g2z_dps, a2x_g, a2y_g, a2z_g (or _mps2) beside g2x_dps, and temperature_c. - reads
    /// standard input.
    log: PathBuf,
    /// The gyroscope's rate: COLUMN[,dps|radps] [default unit: as the name ends, else dps].
    #[arg(long, value_name = "COLUMN")]
    rate: String,
    /// The measured angle: COLUMN[,deg|rad] [default unit: as the name ends, else deg].
    #[arg(long, value_name = "COLUMN")]
    angle: String,
    /// The time stamps: COLUMN[,s|ms|us].
    #[arg(long, value_name = "COLUMN", default_value = "t_s")]
    time: String,
    /// 1, or -1 where the rate is negative while the angle grows.
    #[arg(long, value_name = "SIGN", default_value_t = 1, allow_negative_numbers = true,
          value_parser = clap::value_parser!(i8).range(-1..=1))]
    sign: i8,
    /// Do not try this kind of effect; may be repeated.
    #[arg(long, value_name = "KIND")]
    without: Vec<String>,
    /// Also try effects of the motion, not of the sensor: a shaft that swings between
    /// the same two stops.
    #[arg(long)]
    motion_effects: bool,
    /// Apply the effects of an earlier JSON report as they are, instead of looking for any.
    #[arg(long, value_name = "FILE")]
    apply: Option<PathBuf>,
    #[command(flatten)]
    table: TableOptions,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

/// The JSON object of an explanation.
#[derive(Serialize, JsonSchema)]
pub(super) struct Report<'a> {
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    log: &'a Path,
    #[serde(flatten)]
    explanation: &'a SensorExplanation,
}

/// The JSON object of a transfer.
#[derive(Serialize, JsonSchema)]
pub(super) struct TransferReport<'a> {
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    log: &'a Path,
    applied: &'a Path,
    transfer: &'a Transfer,
}

/// What is read of an earlier report.
#[derive(Deserialize)]
struct Earlier {
    schema: String,
    effects: Vec<Effect>,
}

pub(super) fn run(options: &ExplainSensorOptions) -> anyhow::Result<()> {
    let columns = options.columns()?;
    let earlier = options.apply.as_deref().map(earlier_effects).transpose()?;
    let read = |table| SensorLog::from_table(table, &columns);
    let SensorLog {
        signals,
        angle_deg,
        notes,
    } = options.table.read(&options.log, read)?;
    for note in &notes {
        output::warning(note);
    }
    let blame = |error: SensorError| {
        let of_the_log = error.is_recordings_fault();
        let error = anyhow::Error::from(error);
        if of_the_log {
            error.context(options.log.display().to_string())
        } else {
            error
        }
    };
    let record = SensorRecord::new(signals, angle_deg).map_err(blame)?;
    let text = match (&options.apply, earlier) {
        (Some(applied), Some(effects)) => {
            let transfer =
                apply_effects(&record, &effects).with_context(|| applied.display().to_string())?;
            let report = TransferReport {
                schema: SCHEMA,
                log: &options.log,
                applied,
                transfer: &transfer,
            };
            options.text(&report, || report.table())?
        }
        _ => {
            let settings = SelectionSettings {
                without: options.without.clone(),
                motion_effects: options.motion_effects,
                ..SelectionSettings::default()
            };
            let explanation = explain_sensor(&record, &settings)
                .map_err(blame)
                .context("--without")?;
            for warning in &explanation.warnings {
                output::warning(warning);
            }
            let report = Report {
                schema: SCHEMA,
                log: &options.log,
                explanation: &explanation,
            };
            options.text(&report, || report.table())?
        }
    };
    output::result(&text)?;
    Ok(())
}

impl ExplainSensorOptions {
    fn columns(&self) -> anyhow::Result<SensorColumns> {
        let time = column(
            &self.time,
            &[
                ("s", TimeUnit::Seconds),
                ("ms", TimeUnit::Milliseconds),
                ("us", TimeUnit::Microseconds),
            ],
        )
        .context("--time")?;
        let rate = column(
            &self.rate,
            &[
                ("dps", RateUnit::DegreesPerSecond),
                ("radps", RateUnit::RadiansPerSecond),
            ],
        )
        .context("--rate")?;
        let angle = column(
            &self.angle,
            &[("deg", AngleUnit::Degrees), ("rad", AngleUnit::Radians)],
        )
        .context("--angle")?;
        if self.sign == 0 {
            return Err(anyhow!("--sign: 0 is no sign, expected 1 or -1"));
        }
        Ok(SensorColumns {
            time,
            rate,
            angle,
            sign: f64::from(self.sign),
        })
    }

    fn text(
        &self,
        report: &impl Serialize,
        table: impl FnOnce() -> String,
    ) -> anyhow::Result<String> {
        Ok(if self.json {
            serde_json::to_string(report).context("JSON")? + "\n"
        } else {
            table()
        })
    }
}

/// The name and unit of `NAME[,UNIT]`: without a unit, that in which the name ends,
/// else the first.
fn column<U: Copy>(argument: &str, units: &[(&str, U)]) -> anyhow::Result<(String, U)> {
    let unit_named = |name: &str| units.iter().find(|(unit, _)| *unit == name);
    if let Some((name, unit)) = argument.rsplit_once(',') {
        let (_, unit) = unit_named(unit.trim()).ok_or_else(|| {
            let names: Vec<_> = units.iter().map(|(name, _)| *name).collect();
            anyhow!(
                "{argument:?}: expected one of the units {}",
                names.join(", ")
            )
        })?;
        return Ok((name.trim().into(), *unit));
    }
    let name = argument.trim();
    let unit = name
        .rsplit_once('_')
        .and_then(|(_, ending)| unit_named(ending))
        .unwrap_or(&units[0]);
    Ok((name.into(), unit.1))
}

fn earlier_effects(path: &Path) -> anyhow::Result<Vec<Effect>> {
    let name = || path.display().to_string();
    let text = read_text(path, MAX_REPORT_BYTES).with_context(name)?;
    let earlier: Earlier = serde_json::from_str(&text).with_context(name)?;
    if earlier.schema != SCHEMA {
        return Err(anyhow!(
            "the schema is {:?}, expected {SCHEMA:?}",
            earlier.schema
        ))
        .with_context(name);
    }
    Ok(earlier.effects)
}

impl Report<'_> {
    /// The answer for people.
    fn table(&self) -> String {
        let found = self.explanation;
        let mut table = output::Table::default();
        table.line("log", self.log.display());
        let stretches = found.stretches_s;
        table.line(
            "stretches",
            format!(
                "fit {:.1} s to {:.1} s, selection to {:.1} s, test to {:.1} s",
                stretches.fit[0], stretches.fit[1], stretches.selection[1], stretches.test[1]
            ),
        );
        table.line(
            "RMS error",
            "            fit      selection           test   within blocks of the test stretch",
        );
        let errors = |error: &ErrorDeg| {
            let columns = [
                error.fit_deg,
                error.selection_deg,
                error.validation_deg,
                error.within_blocks_deg,
            ];
            columns
                .map(|error_deg| format!("{error_deg:>14.3}°"))
                .concat()
        };
        let row = |error: &ErrorDeg, text: &str| format!("{}   {text}", errors(error));
        table.lines(
            "baselines",
            found
                .baselines
                .iter()
                .map(|baseline| row(&baseline.error_deg, baseline.name)),
        );
        table.lines(
            "with",
            found.effects.iter().filter_map(|effect| {
                let error = effect.error_deg.as_ref()?;
                Some(row(error, &effect.kind))
            }),
        );
        table.line(
            "refitted",
            row(&found.error_after, "all of them, on fit and selection"),
        );
        table.lines("effects", found.effects.iter().map(effect_text));
        table.line(
            "noise floor",
            format!("{:.3}° on the test stretch", found.noise_floor_deg),
        );
        table.lines(
            "not added",
            found.candidates.iter().map(|candidate| {
                let error = candidate
                    .selection_deg
                    .map_or("      ".into(), |error| format!("{error:.3}°"));
                format!("{:<24}{error:>10}  {}", candidate.kind, candidate.verdict)
            }),
        );
        let residual = &found.residual;
        table.line("residual", &residual.explains);
        if let (Some(frequency_hz), Some(amplitude_deg)) =
            (residual.frequency_hz, residual.amplitude_deg)
        {
            table.line(
                "",
                format!(
                    "strongest at {frequency_hz:.3} Hz with {amplitude_deg:.3}°, whiteness p = {:.2}",
                    residual.whiteness_p_value
                ),
            );
        }
        table.line("unexplained", if found.unexplained { "yes" } else { "no" });
        table.into_text()
    }
}

fn effect_text(effect: &Effect) -> String {
    let parameters = effect.parameters.iter().map(|(name, value)| {
        let interval = effect
            .interval_95
            .get(name)
            .map_or(String::new(), |[low, high]| {
                format!(" ({low:.5} to {high:.5})")
            });
        format!("{name} {value:.5}{interval}")
    });
    let mut text = format!(
        "{}: {}",
        effect.kind,
        parameters.collect::<Vec<_>>().join(", ")
    );
    if !effect.rivals.is_empty() {
        text += &format!(
            "; not significantly better than {}",
            effect.rivals.join(", ")
        );
    }
    text
}

impl TransferReport<'_> {
    /// The answer for people.
    fn table(&self) -> String {
        let transfer = self.transfer;
        let mut table = output::Table::default();
        table.line("log", self.log.display());
        table.line("effects of", self.applied.display());
        table.line("RMS error", format!("{:>9}   within blocks", ""));
        let line = |error: f64, within: f64| format!("{error:>9.3}°   {within:>9.3}°");
        table.line(
            "data sheet",
            line(transfer.error_before_deg, transfer.within_blocks_before_deg),
        );
        table.line(
            "with effects",
            line(transfer.error_after_deg, transfer.within_blocks_after_deg),
        );
        for effect in &transfer.effects {
            let errors = effect
                .error_without_deg
                .zip(effect.within_blocks_without_deg);
            table.line(
                "without",
                format!(
                    "{:>24}   {}: {}",
                    errors.map_or(String::new(), |(error, within)| line(error, within)),
                    effect.kind,
                    effect.verdict
                ),
            );
        }
        table.into_text()
    }
}
