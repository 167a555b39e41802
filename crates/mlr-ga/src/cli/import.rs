//! `mlr-ga import`.

use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use mlr_exchange::{ImportOptions, Imported, JointMap, MOST_URDF_BYTES, import_urdf};
use mlr_imu::read_text;
use schemars::JsonSchema;
use serde::Serialize;

use super::output::{self, ResultFile};

/// Version of the JSON output.
const SCHEMA: &str = "mlr.import/1";

#[derive(Debug, Args)]
pub(super) struct ImportRobotOptions {
    /// The URDF of a healthy robot, run through xacro.
    #[arg(value_name = "URDF")]
    urdf: PathBuf,
    /// Write the description to this file, in TOML, which every command takes as --robot. An existing
    /// file is never overwritten.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Hold this joint still, as part of what it hangs on: of an arm, a camera, or whatever is no
    /// leg. May be given several times.
    #[arg(long, value_name = "JOINT")]
    fixed: Vec<String>,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(options: &ImportRobotOptions) -> anyhow::Result<()> {
    let name = || options.urdf.display().to_string();
    let text = read_text(&options.urdf, MOST_URDF_BYTES).with_context(name)?;
    let imported = import_urdf(
        &text,
        &ImportOptions {
            fixed_joints: options.fixed.clone(),
        },
    )
    .with_context(name)?;
    ResultFile::reserve(&options.output)?.write(&imported.description)?;
    for what in &imported.assumed {
        output::message(&format!("assumed: {what}"));
    }
    for what in &imported.left_out {
        output::message(&format!("left out: {what}"));
    }
    let text = match options.json {
        true => json_report(&imported, options)?,
        false => table(&imported, options),
    };
    Ok(output::result(&text)?)
}

/// The JSON object about the description.
#[derive(Serialize, JsonSchema)]
pub(super) struct Report<'a> {
    #[schemars(extend("const" = SCHEMA))]
    schema: &'static str,
    urdf: String,
    /// The description.
    file: String,
    robot: &'a str,
    /// Names of the legs, in their order.
    legs: Vec<&'a str>,
    joints: &'a [JointMap],
    mass_kg: f64,
    /// The largest distance between a foot of the URDF and of the description.
    foot_error_m: f64,
    /// What the URDF does not say, and what was put in its place.
    assumed: &'a [String],
    /// What a description cannot hold.
    left_out: &'a [String],
}

fn json_report(imported: &Imported, options: &ImportRobotOptions) -> serde_json::Result<String> {
    let robot = &imported.robot;
    let report = Report {
        schema: SCHEMA,
        urdf: options.urdf.display().to_string(),
        file: options.output.display().to_string(),
        robot: robot.name(),
        legs: robot.legs().iter().map(|leg| leg.name.as_str()).collect(),
        joints: &imported.joints,
        mass_kg: robot.mass_kg(),
        foot_error_m: imported.foot_error_m,
        assumed: &imported.assumed,
        left_out: &imported.left_out,
    };
    Ok(serde_json::to_string(&report)? + "\n")
}

/// The report for people.
fn table(imported: &Imported, options: &ImportRobotOptions) -> String {
    let robot = &imported.robot;
    let mut table = output::Table::default();
    table.line("robot", robot.name());
    table.line("file", options.output.display());
    let legs = robot.legs().iter();
    let names: Vec<String> = legs
        .map(|leg| format!("{} ({} links)", leg.name, leg.links.len()))
        .collect();
    table.line("legs", names.join(", "));
    table.line("mass", format!("{:.4} kg", robot.mass_kg()));
    table.line(
        "feet",
        format!(
            "within {:.2} mm of the URDF's, joints within 0.5 rad of zero",
            1e3 * imported.foot_error_m
        ),
    );
    let turned = imported.joints.iter();
    let turned = turned.filter(|joint| joint.sign < 0.0 || joint.offset_rad.abs() > 1e-6);
    let lines = turned.map(|joint| {
        let sign = if joint.sign < 0.0 { "-" } else { "" };
        let offset = match joint.offset_rad.abs() > 1e-6 {
            true => format!(" {:+.4} rad", joint.offset_rad),
            false => String::new(),
        };
        format!("{} = {sign}{}{offset}", joint.joint, joint.urdf_joint)
    });
    table.lines("angles", lines);
    table.into_text()
}
