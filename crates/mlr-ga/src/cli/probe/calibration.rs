//! `mlr-ga probe --calibrate`.

use anyhow::bail;
use mlr_ga::{Configuration, ProbeReport, ProbeSettings, calibration_motion};
use mlr_model::Gait;

use super::{
    super::{output, progress::Bar},
    ProbeOptions, segment,
};

/// The motion of a healthy robot that tells most about its own parameters.
pub(super) fn run(options: &ProbeOptions, settings: ProbeSettings) -> anyhow::Result<()> {
    let Configuration {
        identification,
        explanation,
        ..
    } = Configuration::read(options.config.as_deref(), None)?;
    let (robot, _, gaits) = options.model.read(1)?;
    let gait = gaits.into_iter().next().unwrap_or_else(Gait::tripod);
    if gait.feet().is_none() {
        bail!(
            "{}: a joint trajectory, expected the motion of feet as --gait",
            gait.name
        );
    }
    let files = options.files.reserve()?;
    let bar = Bar::of_motions();
    let simulation = &identification.simulation;
    let found = calibration_motion(&robot, &gait, simulation, &explanation, settings, &bar);
    bar.clear();
    let motion = found?;
    files.write(&motion.gait, &robot)?;
    let report = ProbeReport::new(&motion, &explanation.nuisance);
    let text = match options.json {
        true => serde_json::to_string(&report)? + "\n",
        false => table(&report, options),
    };
    Ok(output::result(&text)?)
}

/// The report for people.
fn table(report: &ProbeReport, options: &ProbeOptions) -> String {
    let mut table = output::Table::default();
    let duration = format!(", {:.1} s", report.duration_s);
    options.files.name("motion", &duration, &mut table);
    table.lines("segments", report.segments.iter().map(segment));
    let left_out = report.left_out.iter();
    let left_out: Vec<String> = left_out
        .map(|(why, count)| format!("{count} {why}"))
        .collect();
    let reasons = match left_out.is_empty() {
        true => String::new(),
        false => format!("; left out: {}", left_out.join(", ")),
    };
    table.line(
        "candidates",
        format!("{} tried{reasons}", report.candidates),
    );
    table.line(
        "information",
        format!(
            "{:.1} nats, a plain walk {:.1} nats; means over {} robots of the make",
            report.motion_gain_nats, report.walk_gain_nats, report.robots
        ),
    );
    table.line(
        "",
        format!("{:<18} {:>4}  ± before  after walk  after motion", "", ""),
    );
    let lines = report.parameters.iter().map(|one| {
        format!(
            "{:<18} {:>4} {:9.4} {:11.4} {:13.4}",
            one.name, one.unit, one.before, one.after_walk, one.after_motion
        )
    });
    table.lines("", lines);
    table.into_text()
}
