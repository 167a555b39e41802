//! `mlr-ga recover`.

use std::{path::PathBuf, time::Instant};

use anyhow::Context;
use clap::Args;
use mlr_ga::{
    Configuration, IdentifySettings, LARGEST_SEED, Model, RecoveryOf, RecoveryReport, ReportedGait,
    ReportedOutlook, diagnosis_of_identification, diagnosis_of_json, identify, recovery_gait,
};
use mlr_imu::Mounting;
use mlr_model::{Fault, Gait, Robot};
use mlr_recover::{Diagnosis, WhatIsLeft};

use super::{
    log_file::{ReadOptions, blame_if},
    model_files::ModelFiles,
    morphology_choice::MorphologyChoice,
    motion_files::MotionFiles,
    output,
    progress::Bar,
    saved_answer::saved_answer,
};

#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("damage").required(true).multiple(true)
    .args(["log", "legs_lost", "morphology", "weak_leg", "stuck_joint"]))]
pub(super) struct RecoverOptions {
    /// A log of the damaged robot, which is identified first; or an answer of identify or explain, or
    /// an event of the daemon with one, as .json.
    #[arg(conflicts_with_all = ["legs_lost", "morphology", "weak_leg", "stuck_joint"])]
    log: Option<PathBuf>,
    #[command(flatten)]
    read: ReadOptions,
    #[command(flatten)]
    morphology: MorphologyChoice,
    /// A leg whose servos have lost strength, with what is left of it, as in 3:0.3. May be repeated.
    #[arg(long, value_name = "LEG:GAIN")]
    weak_leg: Vec<String>,
    /// A joint that ignores its commands, by leg, joint (from the body outward) and its angle in
    /// radians, as in 3:2:0.9. May be repeated.
    #[arg(long, value_name = "LEG:JOINT:ANGLE")]
    stuck_joint: Vec<String>,
    #[command(flatten)]
    files: MotionFiles,
    /// Chooses the robots that are tried, and the gaits.
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true,
          value_parser = clap::value_parser!(u64).range(..=LARGEST_SEED))]
    seed: u64,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
    /// All settings, in TOML, such as the daemon's /etc/mlrd.toml.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    #[command(flatten)]
    model: ModelFiles,
}

pub(super) fn run(options: &RecoverOptions) -> anyhow::Result<()> {
    let started = Instant::now();
    let Configuration {
        identification,
        explanation,
        mounting,
        recovery,
        ..
    } = Configuration::read(options.config.as_deref(), None)?;
    let (robot, gait) = options.model.read()?;
    let files = options.files.reserve()?;
    let diagnosis = options.diagnosis(&robot, &gait, &identification, &mounting)?;
    let of = RecoveryOf {
        robot: &robot,
        gait: &gait,
        diagnosis: &diagnosis,
        simulation: &identification.simulation,
        nuisance: &explanation.nuisance,
        detector: identification.detector,
    };
    let bar = Bar::of_gaits();
    let found = recovery_gait(of, &recovery, options.seed, &bar);
    bar.clear();
    let found = found?;
    files.write(&found.gait, &robot)?;
    let report = RecoveryReport::new(&diagnosis, &found, options.seed, started.elapsed());
    let text = match options.json {
        true => serde_json::to_string(&report)? + "\n",
        false => table(&report, options, &robot),
    };
    Ok(output::result(&text)?)
}

/// How the name of an answer ends.
const ANSWER: &str = "json";

impl RecoverOptions {
    fn diagnosis(
        &self,
        robot: &Robot,
        gait: &Gait,
        settings: &IdentifySettings,
        mounting: &Mounting,
    ) -> anyhow::Result<Diagnosis> {
        let Some(log) = &self.log else {
            let left = WhatIsLeft {
                faults: self.faults()?,
                ..WhatIsLeft::of(self.morphology.of(&robot.layout())?)
            };
            return Ok(Diagnosis::certain(left));
        };
        if log.extension().is_some_and(|extension| extension == ANSWER) {
            return saved_answer(log, |text| diagnosis_of_json(robot, text));
        }
        let settings = IdentifySettings {
            seed: self.seed,
            ..settings.clone()
        };
        let recording = self.read.recording(log)?.mounted(mounting)?;
        let bar = Bar::new();
        let found = identify(&recording, Model::new(robot, gait), &settings, &bar);
        bar.clear();
        let found = found.map_err(|error| {
            let of_the_log = error.is_recordings_fault();
            blame_if(of_the_log, log, error.into())
        })?;
        for warning in &found.warnings {
            output::warning(warning);
        }
        if found.implausible {
            output::warning("no morphology explains this log: the gait is for the closest one");
        }
        Ok(diagnosis_of_identification(&found))
    }

    fn faults(&self) -> anyhow::Result<Vec<Fault>> {
        let mut faults = Vec::new();
        for text in &self.weak_leg {
            let fault = text.split_once(':').and_then(|(leg, gain)| {
                Some(Fault::WeakLeg {
                    leg: leg.trim().parse().ok()?,
                    gain: gain.trim().parse().ok()?,
                })
            });
            let context = || format!("--weak-leg {text}: expected leg and gain, as in 3:0.3");
            faults.push(fault.with_context(context)?);
        }
        for text in &self.stuck_joint {
            let mut parts = text.split(':').map(str::trim);
            let mut next = || parts.next();
            let fault = (|| {
                Some(Fault::StuckJoint {
                    leg: next()?.parse().ok()?,
                    joint: next()?.parse().ok()?,
                    angle_rad: next()?.parse().ok()?,
                })
            })();
            let context =
                || format!("--stuck-joint {text}: expected leg, joint and angle, as in 3:2:0.9");
            faults.push(fault.filter(|_| next().is_none()).with_context(context)?);
        }
        Ok(faults)
    }
}

/// The report for people.
fn table(report: &RecoveryReport, options: &RecoverOptions, robot: &Robot) -> String {
    let mut table = output::Table::default();
    let mut left = damage(&report.gait, robot);
    if report.cases > 1 {
        left += &format!("; {} cases in question", report.cases);
    }
    table.line("damage", left);
    options.files.name("gait", "", &mut table);
    table.line("swings", swings(&report.gait));
    let margin_mm = 1e3 * report.margin_m;
    table.line(
        "stability",
        match report.statically_stable {
            true => format!(
                "centre of mass at least {margin_mm:.0} mm inside the feet that stand, {:.0} mm on the way into the gait",
                1e3 * report.first_steps_margin_m
            ),
            false => format!(
                "nothing statically stable was found ({margin_mm:.0} mm): this is the best limp"
            ),
        },
    );
    table.line(
        "",
        format!(
            "{:>8} {:>12} {:>12} {:>8} {:>10} {:>10}",
            "speed", "fluctuation", "worst", "drift", "torque", "below 5°"
        ),
    );
    table.line("before", outlook(&report.before));
    table.line("after", outlook(&report.after));
    if !report.better_than_nominal {
        table.line("", "the nominal gait can be counted on for as much");
    }
    table.line(
        "first steps",
        format!(
            "{:.1} s, fluctuation up to {:.1}°",
            report.gait.steady_from_s, report.first_steps_fluctuation_deg
        ),
    );
    table.line(
        "time",
        format!("{:.1} s, {} robots", report.elapsed_s, report.robots),
    );
    table.into_text()
}

/// What a gait is for.
pub(super) fn damage(gait: &ReportedGait, robot: &Robot) -> String {
    let mut text = gait.morphology.describe_on(robot);
    for fault in &gait.faults {
        text += &match *fault {
            Fault::WeakLeg { leg, gain } => format!(", leg {leg} weak ({:.0} %)", 100.0 * gain),
            Fault::StuckJoint { leg, joint, .. } => format!(", joint {joint} of leg {leg} stuck"),
            Fault::JointOffset { leg, joint, .. } => format!(", joint {joint} of leg {leg} off"),
            Fault::ShortLink { leg, link, .. } => format!(", link {link} of leg {leg} short"),
            Fault::FootFriction { leg, .. } => format!(", foot {leg} slips otherwise"),
            Fault::ExternalForce { .. } => ", pulled at".into(),
        };
    }
    if let Some(payload) = &gait.payload {
        text += &format!(", a load of {:.2} kg", payload.mass_kg);
    }
    text
}

/// Which legs swing when, and how.
pub(super) fn swings(gait: &ReportedGait) -> String {
    let order: Vec<String> = gait.order.iter().map(|legs| numbers(legs)).collect();
    format!(
        "{}; duty factor {:.2}, period {:.2} s, stride {:.0} mm, lift {:.0} mm, body at {:.0} mm",
        order.join(" - "),
        gait.duty_factor,
        gait.period_s,
        1e3 * gait.stride_m,
        1e3 * gait.lift_m,
        1e3 * gait.body_height_m
    )
}

fn numbers(legs: &[usize]) -> String {
    let legs: Vec<String> = legs.iter().map(usize::to_string).collect();
    legs.join("+")
}

fn outlook(outlook: &ReportedOutlook) -> String {
    let mean = &outlook.mean;
    format!(
        "{:>4.0} mm/s {:>11.1}° {:>11.1}° {:>4.1} °/m {:>8.0} % {:>8.0} %",
        1e3 * mean.speed_m_per_s,
        mean.fluctuation_deg,
        outlook.worst_fluctuation_deg,
        mean.drift_deg_per_m,
        100.0 * mean.torque_share,
        100.0 * outlook.calm_probability
    )
}
