//! `mlr-ga report`.

use std::{
    fs,
    path::{Path, PathBuf},
    time::Instant,
};

use anyhow::{Context, bail, ensure};
use clap::Args;
use mlr_ga::{
    AnswerJsonError, BestFit, Comparison, Detection, DetectionSettings, IdentifySettings, Model,
    Question, answer_of_json, compare, compare_fit, detect, gait_of_file,
};
use mlr_imu::{Recording, printable};
use mlr_model::Robot;
use mlr_report::{
    Manifest, Report, Walk,
    answer::{Explanation, Identification},
    plots::{Footfalls, WalkSignals},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{
    identification::{Asked, IdentificationOptions},
    log_file,
    output::{self, ResultFile, file_name},
    plot,
    saved_answer::saved_answer,
};

/// Version of the JSON output.
const SCHEMA: &str = "mlr.report/1";

/// Pixels of a PNG for each of its SVG: a column of a paper at 300 dpi has half of them.
const PNG_SCALE: f32 = 4.0;

/// An answer belongs to a log on which its morphology has the same F, but for what two versions of the
/// program may differ by.
const SAME_COST: f64 = 0.02;
/// The same of the start of the compared stretch.
const SAME_START_S: f64 = 0.005;

/// The JSON object about a page.
#[derive(Serialize, JsonSchema)]
pub(super) struct Made {
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    /// The page.
    file: String,
    /// Its size.
    bytes: usize,
    /// Files of the plots, if they were asked for.
    plots: Vec<String>,
    /// What a page could show and this one does not, with the command that computes it.
    not_computed: Vec<&'static str>,
    /// Time that it took.
    elapsed_s: f64,
}

#[derive(Debug, Args)]
pub(super) struct ReportOptions {
    #[command(flatten)]
    identification: IdentificationOptions,
    /// The page, in HTML. An existing file is never overwritten.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The identification of these logs, as identify printed it with --json, or an event of the daemon
    /// with one; without it, the robot is identified first. Name the same logs, --robot, --gait and
    /// --config as there.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["search", "seed", "repeats", "atlas"])]
    answer: Option<PathBuf>,
    /// What else is wrong with the robot, as explain printed it with --json.
    #[arg(long, value_name = "FILE")]
    explanation: Option<PathBuf>,
    /// A gait that walks again, as recover wrote it.
    #[arg(long, value_name = "FILE")]
    recovery: Option<PathBuf>,
    /// Also write the plots one by one into this folder, as SVG and PNG. It must not exist, or be empty.
    #[arg(long, value_name = "FOLDER")]
    plots: Option<PathBuf>,
    /// Print one JSON object about the files instead of a table.
    #[arg(long)]
    json: bool,
}

/// How an answer fits each log.
#[derive(Deserialize)]
struct Fits {
    fit: BestFit,
    #[serde(default)]
    logs: Vec<FitOfLog>,
}

#[derive(Deserialize)]
struct FitOfLog {
    fit: BestFit,
}

pub(super) fn run(options: &ReportOptions) -> anyhow::Result<()> {
    let started = Instant::now();
    let asked = options.identification.asked()?;
    let page = ResultFile::reserve(&options.output)?;
    if let Some(folder) = &options.plots {
        require_empty(folder)?;
    }
    let read = |text: &str| -> Result<(Identification, Fits), AnswerJsonError> {
        let question = Question::Identification;
        let found = answer_of_json(text, &asked.robot, question)?;
        Ok((found, answer_of_json(text, &asked.robot, question)?))
    };
    let saved = options.answer.as_deref();
    let saved = saved.map(|path| saved_answer(path, read)).transpose()?;
    let explanation = options.explanation(&asked.robot)?;
    let recordings = options.identification.recordings(&asked)?;
    let (found, fits) = match saved {
        Some(answer) => answer,
        None => {
            let asking = &options.identification;
            let answer = asking.answer(&asked, &recordings, started)?;
            read(&serde_json::to_string(&answer)?).context("the identification")?
        }
    };
    let compared = options.compared(&asked, &recordings, &found, &fits)?;
    let detections = options.detections(&asked.settings, &recordings);
    let footfalls = options.footfalls(&asked.robot, &found)?;
    let walks = compared.into_iter().zip(&detections).enumerate();
    let walks = walks.map(|(index, (comparison, detection))| {
        let path = &options.identification.logs().paths()[index];
        Ok(Walk {
            log: shown(path),
            sha256: log_file::sha256(path)?,
            gait: &asked.gaits[index],
            error_deg: comparison.mean_error_deg,
            signals: signals(comparison, &found, index, &asked.settings),
            detector: match detection {
                Ok((detection, orientation)) => Ok(plot::detector_run(detection, orientation)),
                Err(reason) => Err(reason.clone()),
            },
        })
    });
    let report = Report {
        robot: &asked.robot,
        identification: &found,
        walks: walks.collect::<anyhow::Result<_>>()?,
        explanation: explanation.as_ref(),
        footfalls,
        manifest: options.manifest(),
    };
    let html = report.page()?;
    page.write(&html)?;
    let plots = options.write_plots(&report)?;
    let file = options.output.display().to_string();
    let text = if options.json {
        let made = Made {
            schema: SCHEMA,
            file,
            bytes: html.len(),
            plots,
            not_computed: report.not_computed(),
            elapsed_s: started.elapsed().as_secs_f64(),
        };
        serde_json::to_string(&made)? + "\n"
    } else {
        let mut table = output::Table::default();
        table.line("damage", &found.description);
        table.line("page", format!("{file} ({} kB)", html.len().div_ceil(1000)));
        table.lines("plots", plots.into_iter());
        table.lines(
            "not computed",
            report.not_computed().into_iter().map(String::from),
        );
        table.line("time", format!("{:.1} s", started.elapsed().as_secs_f64()));
        table.into_text()
    };
    Ok(output::result(&text)?)
}

impl ReportOptions {
    fn explanation(&self, robot: &Robot) -> anyhow::Result<Option<Explanation>> {
        let Some(path) = &self.explanation else {
            return Ok(None);
        };
        let question = Question::Explanation;
        let mut found: Explanation =
            saved_answer(path, |text| answer_of_json(text, robot, question))?;
        // The same log may have moved; another one should not pass unnoticed.
        let logs = self.identification.logs().names();
        if !logs
            .iter()
            .any(|log| file_name(log) == file_name(&found.log))
        {
            let warning = format!("the explanation is of another log: {}", found.log);
            output::warning(&warning);
            found.warnings.push(warning);
        }
        Ok(Some(found))
    }

    /// The walk of the best morphology beside each log, on the model that fits it best.
    fn compared(
        &self,
        asked: &Asked,
        recordings: &[Recording],
        found: &Identification,
        fits: &Fits,
    ) -> anyhow::Result<Vec<Comparison>> {
        let answer = match &self.answer {
            Some(path) => path.display().to_string(),
            None => "the identification".into(),
        };
        let several: Vec<&BestFit> = fits.logs.iter().map(|log| &log.fit).collect();
        let fits = if several.is_empty() {
            vec![&fits.fit]
        } else {
            several
        };
        ensure!(
            fits.len() == recordings.len(),
            "{answer}: is of {} logs, expected an answer to the {} that are named: name the same logs as there",
            fits.len(),
            recordings.len()
        );
        let mut compared = Vec::new();
        let mut cost_rad = 0.0;
        for (index, ((recording, gait), fit)) in
            recordings.iter().zip(&asked.gaits).zip(fits).enumerate()
        {
            let blame = |error| self.identification.logs().blame(index, error);
            let model = Model::new(&asked.robot, gait);
            let morphology = || found.morphology.clone();
            let nominal = IdentifySettings {
                lost_links: fit.lost_links.into(),
                ..asked.settings.clone()
            };
            let plain = compare(recording, model, &nominal, morphology()).map_err(blame)?;
            cost_rad += plain.cost_rad;
            let [start_s, _] = found.window_s(index);
            ensure!(
                (plain.window_start_s - start_s).abs() <= SAME_START_S,
                "{answer}: compares from {start_s:.2} s on, here it would be {:.2} s: {SAME}",
                plain.window_start_s
            );
            let fitted = compare_fit(recording, model, &asked.settings, morphology(), fit);
            compared.push(fitted.map_err(blame)?);
        }
        ensure!(
            (cost_rad - found.cost_rad).abs() <= SAME_COST * found.cost_rad.max(cost_rad),
            "{answer}: says F = {:.2} rad of its morphology, here it is {cost_rad:.2} rad: {SAME}",
            found.cost_rad
        );
        Ok(compared)
    }

    /// What the detector makes of each log, with what it saw; or why it makes nothing.
    fn detections(
        &self,
        settings: &IdentifySettings,
        recordings: &[Recording],
    ) -> Vec<Result<(Detection, mlr_filter::OrientationSeries), String>> {
        let settings = DetectionSettings::from(settings);
        let each = recordings.iter().map(|recording| {
            let detection = detect(recording, &settings).map_err(|error| error.to_string())?;
            let (recording, _) = recording.clone().with_increasing_times();
            Ok((detection, recording.orientation))
        });
        each.collect()
    }

    fn footfalls(
        &self,
        robot: &Robot,
        found: &Identification,
    ) -> anyhow::Result<Option<Footfalls>> {
        let Some(path) = &self.recovery else {
            return Ok(None);
        };
        let name = || path.display().to_string();
        let gait = gait_of_file(path)?;
        let footfalls = Footfalls::of(robot, &gait, &found.morphology).with_context(name)?;
        let no_cycle = "the motion ends, expected a gait that repeats itself, as recover writes it";
        Ok(Some(footfalls.context(no_cycle).with_context(name)?))
    }

    fn manifest(&self) -> Manifest {
        let robot_file = self.identification.robot_file();
        Manifest {
            program: format!("mlr-ga {}", env!("MLR_VERSION")),
            identification: match &self.answer {
                Some(path) => format!("read from {}", shown(path)),
                None => "made for this page".into(),
            },
            robot_file: robot_file.map(shown),
        }
    }

    /// Writes the plots, if they were asked for; the names of their files.
    fn write_plots(&self, report: &Report<'_>) -> anyhow::Result<Vec<String>> {
        let Some(folder) = &self.plots else {
            return Ok(Vec::new());
        };
        let name = || folder.display().to_string();
        fs::create_dir_all(folder).with_context(name)?;
        let mut files = Vec::new();
        for picture in report.plots()? {
            let png = picture.png(PNG_SCALE)?;
            for (ending, content) in [("svg", picture.svg().as_bytes()), ("png", &png)] {
                let path = folder.join(picture.name()).with_extension(ending);
                ResultFile::reserve(&path)?.write(content)?;
                files.push(path.display().to_string());
            }
        }
        Ok(files)
    }
}

/// What to do about an answer of something else.
const SAME: &str = "expected the answer to these logs; name the same logs, --robot, --gait, --config, \
                    --friction, --from-s and --window-s as there";

fn signals(
    comparison: Comparison,
    found: &Identification,
    log: usize,
    settings: &IdentifySettings,
) -> WalkSignals {
    let signals = comparison.signals;
    WalkSignals {
        measured: signals.measured_unfiltered,
        simulated: signals.simulated_unfiltered,
        measured_filtered: signals.measured,
        simulated_filtered: signals.simulated,
        filter: settings.filter,
        duration_s: found.window_s(log)[1],
    }
}

/// The last part of a path, without what is invisible or turns the direction of writing.
fn shown(path: &Path) -> String {
    printable(&file_name(&path.display().to_string()))
}

/// Plots go where nothing can be overwritten.
fn require_empty(folder: &Path) -> anyhow::Result<()> {
    let name = || folder.display().to_string();
    match fs::read_dir(folder) {
        Ok(mut entries) => {
            if entries.next().is_some() {
                bail!(
                    "{}: is not empty, expected a folder that is, or a new one for the plots",
                    name()
                );
            }
            Ok(())
        }
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(()),
        Err(error) => Err(error).with_context(name),
    }
}
