//! `mlr-ga export`.

use std::path::PathBuf;

use anyhow::bail;
use clap::{Args, ValueEnum};
use mlr_exchange::{ExportedRobot, Format};
use mlr_ga::AnsweredRobot;
use mlr_model::{Fault, Gait, LostLinks, Morphology, Payload, SimulationSettings};
use schemars::JsonSchema;
use serde::Serialize;

use super::{
    model_files::ModelFiles,
    morphology_choice::{LossName, MorphologyChoice},
    output::{self, ResultFile},
    saved_answer::saved_answer,
};

/// Version of the JSON output.
const SCHEMA: &str = "mlr.export/1";

#[derive(Debug, Args)]
pub(super) struct ExportOptions {
    /// What to write.
    #[arg(long, value_enum)]
    format: FormatName,
    /// The file to write; without it, the robot goes to stdout. An existing file is never
    /// overwritten.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// The robot as an answer has it: a file with the JSON of identify or explain, or an event of
    /// the daemon with one. Name the same --robot as there.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["legs_lost", "morphology", "lost_links"])]
    answer: Option<PathBuf>,
    #[command(flatten)]
    morphology: MorphologyChoice,
    /// What became of lost links [default: absent, or what the answer says].
    #[arg(long, value_enum)]
    lost_links: Option<LossName>,
    /// Print one JSON object about the file instead of a table.
    #[arg(long, requires = "output")]
    json: bool,
    #[command(flatten)]
    model: ModelFiles,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum FormatName {
    /// Unified Robot Description Format, of ROS and most robotics libraries.
    Urdf,
    /// MuJoCo's, with servos, ground and a keyframe in which the robot stands.
    Mjcf,
    /// All parts with frames, masses and contacts, for programs.
    Json,
}

impl From<FormatName> for Format {
    fn from(name: FormatName) -> Self {
        match name {
            FormatName::Urdf => Self::Urdf,
            FormatName::Mjcf => Self::Mjcf,
            FormatName::Json => Self::Json,
        }
    }
}

/// The JSON object about the file.
#[derive(Serialize, JsonSchema)]
pub(super) struct Report<'a> {
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    file: String,
    morphology: &'a Morphology,
    /// The morphology in words.
    description: String,
    lost_links: LostLinks,
    faults: &'a [Fault],
    payload: Option<Payload>,
    /// How many joints obey their commands.
    joints: usize,
    mass_kg: f64,
    /// In the body frame, with all legs straight.
    center_of_mass_straight_m: [f64; 3],
    /// What the format cannot hold.
    left_out: &'a [String],
}

pub(super) fn run(options: &ExportOptions) -> anyhow::Result<()> {
    let format = Format::from(options.format);
    // Only how a robot stands depends on its gait.
    let (described, gait) = match format {
        Format::Mjcf => options.model.read()?,
        Format::Urdf | Format::Json => (options.model.robot()?, Gait::tripod()),
    };
    let answered = match &options.answer {
        Some(path) => saved_answer(path, |text| AnsweredRobot::from_json(text, &described))?,
        None => AnsweredRobot {
            morphology: options.morphology.of(&described.layout())?,
            robot: described,
            settings: SimulationSettings {
                lost_links: options.lost_links.map_or(LostLinks::default(), Into::into),
                ..SimulationSettings::default()
            },
            left_out: Vec::new(),
            doubtful: false,
        },
    };
    if answered.doubtful {
        output::warning("the answer says that it does not explain its log");
    }
    let AnsweredRobot {
        robot,
        morphology,
        settings,
        ..
    } = &answered;
    let exported = ExportedRobot::new(robot, morphology, settings)?;
    let of_effects = answered.left_out.iter();
    let mut left_out: Vec<String> = of_effects
        .map(|kind| format!("{kind}, which is none of the robot's"))
        .collect();
    left_out.extend(exported.left_out(format));
    let text = exported.written(format, &gait)?;
    let Some(path) = &options.output else {
        for what in &left_out {
            output::message(&format!("left out: {what}"));
        }
        return Ok(output::result(&text)?);
    };
    if path.as_os_str() == output::STDOUT {
        bail!("-: expected the name of a file, or no -o for stdout (for one called -, ./-)");
    }
    ResultFile::reserve(path)?.write(&text)?;
    let assembly = exported.assembly();
    let center_m = exported.center_of_mass_m();
    let file = path.display().to_string();
    let text = if options.json {
        let report = Report {
            schema: SCHEMA,
            file,
            morphology,
            description: morphology.describe(),
            lost_links: settings.lost_links,
            faults: &settings.faults,
            payload: settings.payload,
            joints: exported.obeying_joints(),
            mass_kg: assembly.mass_kg(),
            center_of_mass_straight_m: center_m.into(),
            left_out: &left_out,
        };
        serde_json::to_string(&report)? + "\n"
    } else {
        let mut table = output::Table::default();
        table.line("robot", robot.name());
        table.line("file", file);
        table.line("morphology", morphology.describe());
        if !settings.faults.is_empty() || settings.payload.is_some() {
            let faults = settings.faults.iter().map(|fault| format!("{fault:?}"));
            let payload = settings.payload.iter().map(|load| format!("{load:?}"));
            table.lines("besides", faults.chain(payload));
        }
        table.line("joints", exported.obeying_joints());
        // Without a sign of zero.
        let [x, y, z] = <[f64; 3]>::from(center_m).map(|m| (1e4 * m).round() / 10.0 + 0.0);
        table.line(
            "mass",
            format!(
                "{:.4} kg, centre at {x}, {y}, {z} mm with straight legs",
                assembly.mass_kg()
            ),
        );
        table.lines("left out", left_out.into_iter());
        table.into_text()
    };
    Ok(output::result(&text)?)
}
