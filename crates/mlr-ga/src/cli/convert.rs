//! `mlr-ga convert`.

use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use mlr_imu::{LogFormat, NewFile, OrientationSource, Recording, write_recording};
use schemars::JsonSchema;
use serde::Serialize;

use super::{log_file::LogFile, output};

/// Version of the JSON output.
const SCHEMA: &str = "mlr.conversion/1";
/// The end of the times that a message's header can hold, in seconds since 1970: the year 2106.
const LATEST_S: f64 = u32::MAX as f64;

#[derive(Debug, Args)]
pub(super) struct ConvertOptions {
    #[command(flatten)]
    log: LogFile,
    /// The new file, whose name ends in .csv, .csv.gz or .mcap. An existing file is never
    /// overwritten.
    #[arg(value_name = "OUT")]
    output: PathBuf,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

/// The JSON object about a conversion.
#[derive(Serialize, JsonSchema)]
pub(super) struct Report<'a> {
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    log: &'a Path,
    /// The new file.
    file: &'a Path,
    samples: usize,
    /// Log time of the first sample.
    begin_s: Option<f64>,
    /// Log time of the last sample.
    end_s: Option<f64>,
    /// Whether the log has an orientation, rather than one that would be fused from raw samples.
    has_orientation: bool,
    has_raw_samples: bool,
    /// What the new file cannot hold.
    left_out: &'a [String],
    /// What a person should know about how the log was read.
    warnings: &'a [String],
}

/// A log, and what a new file of its samples lacks.
struct Converted {
    recording: Recording,
    /// What its time zero is, in nanoseconds since 1970.
    begin_ns: i64,
    left_out: Vec<String>,
}

pub(super) fn run(options: &ConvertOptions) -> anyhow::Result<()> {
    // Before the work.
    let format = LogFormat::of_name(&options.output);
    if format.is_some() {
        let name = options.output.display();
        NewFile::reserve(&options.output).map_err(|error| anyhow::anyhow!("{name}: {error}"))?;
    }
    let mut converted = options.read()?;
    for note in &converted.recording.notes {
        output::warning(note);
    }
    match format {
        Some(LogFormat::Mcap) => converted.fit_into_messages()?,
        _ => converted.count_from_the_first(),
    }
    write_recording(&options.output, &converted.recording, converted.begin_ns)?;
    for what in &converted.left_out {
        output::message(&format!("left out: {what}"));
    }
    Ok(output::result(&match options.json {
        true => options.json_report(&converted)?,
        false => options.table(&converted),
    })?)
}

impl ConvertOptions {
    fn read(&self) -> anyhow::Result<Converted> {
        self.log.read_table(|table, columns| {
            let (begin_ns, left_out) = match table.messages() {
                Some(messages) => {
                    let mut left_out = vec!["covariances and the name of the frame".into()];
                    if messages.others() > 0 {
                        left_out.push(format!("{} messages on other topics", messages.others()));
                    }
                    (messages.begin_ns(), left_out)
                }
                None => {
                    let unread = table.names().iter().filter(|name| !columns.has(name));
                    let left_out = unread.map(|name| format!("column {name:?}"));
                    (0, left_out.collect())
                }
            };
            Ok(Converted {
                recording: Recording::from_table(table, columns)?,
                begin_ns,
                left_out,
            })
        })
    }

    fn json_report(&self, converted: &Converted) -> serde_json::Result<String> {
        let recording = &converted.recording;
        let times_s = recording.orientation.times_s();
        let report = Report {
            schema: SCHEMA,
            log: self.log.path(),
            file: &self.output,
            samples: times_s.len(),
            begin_s: times_s.first().copied(),
            end_s: times_s.last().copied(),
            has_orientation: recording.source == OrientationSource::Recorded,
            has_raw_samples: recording.raw.is_some(),
            left_out: &converted.left_out,
            warnings: &recording.notes,
        };
        Ok(serde_json::to_string(&report)? + "\n")
    }

    /// The report for people.
    fn table(&self, converted: &Converted) -> String {
        let recording = &converted.recording;
        let times_s = recording.orientation.times_s();
        let what = match (recording.source, recording.raw.is_some()) {
            (OrientationSource::Fused, _) => "raw samples",
            (OrientationSource::Recorded, true) => "orientation and raw samples",
            (OrientationSource::Recorded, false) => "orientation",
        };
        let mut table = output::Table::default();
        table.line("file", self.output.display());
        table.line("samples", format!("{} of {what}", times_s.len()));
        if let (Some(begin_s), Some(end_s)) = (times_s.first(), times_s.last()) {
            table.line("time", format!("{begin_s:.3} s to {end_s:.3} s"));
        }
        table.into_text()
    }
}

impl Converted {
    /// A message's header holds no times before 1970, and none after 2106.
    fn fit_into_messages(&mut self) -> anyhow::Result<()> {
        let times_s = self.recording.orientation.times_s();
        let since_1970_s = |time_s: f64| time_s + self.begin_ns as f64 * 1e-9;
        let ends_s = times_s.iter().copied().map(since_1970_s);
        let (earliest_s, latest_s) = ends_s
            .fold((f64::INFINITY, 0.0_f64), |(low, high), time_s| {
                (low.min(time_s), high.max(time_s))
            });
        let later_s = (-earliest_s).max(0.0).ceil();
        if latest_s + later_s > LATEST_S {
            bail!(
                "the log ends {latest_s:e} s after its time zero, more than a message can hold; is \
                 its time in another unit, as in --column t=t_s,ms?"
            );
        }
        if later_s > 0.0 {
            self.begin_ns = self.begin_ns.saturating_add((later_s * 1e9) as i64);
            self.left_out.push(format!(
                "times before zero: every message is {later_s} s later"
            ));
        }
        Ok(())
    }

    /// Tables say nothing of the day.
    fn count_from_the_first(&mut self) {
        if self.begin_ns > 0 {
            let begin_s = self.begin_ns as f64 * 1e-9;
            self.left_out.push(format!(
                "the date: times count from the first message, {begin_s:.6} s after 1970"
            ));
        }
    }
}
