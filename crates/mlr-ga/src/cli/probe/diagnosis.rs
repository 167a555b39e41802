//! `mlr-ga probe LOG` and `mlr-ga probe --explanation FILE`.

use mlr_ga::{
    Configuration, DiagnosisReport, IdentifySettings, OpenQuestion, OpenRobot, ProbeSettings,
    diagnosis_motion, identify_together,
};
use mlr_imu::Mounting;
use mlr_model::{Gait, Robot};

use super::{
    super::{log_file::LogFiles, output, progress::Bar, saved_answer::saved_answer},
    ProbeOptions, segment,
};

/// The motion that tells most about what the logs leave open.
pub(super) fn run(options: &ProbeOptions, settings: ProbeSettings) -> anyhow::Result<()> {
    let configuration = Configuration::read(options.config.as_deref(), None)?;
    let identification = IdentifySettings {
        seed: options.seed,
        ..configuration.identification
    };
    let (robot, _, gaits) = options.model.read(options.logs.len().max(1))?;
    identification.check_on(&robot)?;
    // The robot stands as a motion of feet has it; all logs may be of other motions.
    let stance = gaits.iter().find(|gait| gait.feet().is_some());
    let stance = stance.cloned().unwrap_or_else(Gait::tripod);
    let files = options.files.reserve()?;
    let question = match &options.explanation {
        Some(path) => saved_answer(path, |text| OpenQuestion::of_explanation(text, &robot))?
            .asking(&options.ask),
        None => of_the_logs(
            options,
            &robot,
            &gaits,
            &identification,
            &configuration.mounting,
        )?,
    };
    let motion = match question.is_sure() {
        true => None,
        false => {
            let bar = Bar::of_motions();
            let found =
                diagnosis_motion(&question, &robot, &stance, &identification, settings, &bar);
            bar.clear();
            Some(found?)
        }
    };
    if let Some(gait) = motion.as_ref().and_then(|motion| motion.gait.as_ref()) {
        files.write(gait, &robot)?;
    }
    let report = DiagnosisReport::new(&question, motion.as_ref());
    let text = match options.json {
        true => serde_json::to_string(&report)? + "\n",
        false => table(&report, options),
    };
    Ok(output::result(&text)?)
}

/// What the logs leave open.
fn of_the_logs(
    options: &ProbeOptions,
    robot: &Robot,
    gaits: &[Gait],
    identification: &IdentifySettings,
    mounting: &Mounting,
) -> anyhow::Result<OpenQuestion> {
    let logs = LogFiles::new(options.logs.clone(), options.read.clone());
    let recordings = logs.read(mounting)?;
    let atlases = options.atlas.open(robot, gaits, identification)?;
    let walks = atlases.walks(&recordings, gaits);
    let bar = Bar::new();
    let answer = identify_together(&walks, robot, identification, &bar);
    bar.clear();
    let answer = answer.map_err(|(log, error)| logs.blame(log, error))?;
    Ok(OpenQuestion::of(&answer))
}

/// A robot in question for people, in one line.
fn open(robot: &OpenRobot) -> String {
    let all = 100.0 * robot.probability;
    let kinds: Vec<&str> = robot.effects.iter().map(|one| one.kind.as_str()).collect();
    let effects = match kinds.is_empty() {
        true => String::new(),
        false => format!(", {}", kinds.join(" and ")),
    };
    let locked = match robot.morphology.is_healthy() {
        true => String::new(),
        false => format!(", locked {:.0} %", 100.0 * robot.locked_probability),
    };
    format!("{}  {all:.0} %{locked}{effects}", robot.morphology)
}

/// The report for people.
fn table(report: &DiagnosisReport, options: &ProbeOptions) -> String {
    let mut table = output::Table::default();
    table.lines("open", report.open.iter().map(open));
    match (report.sure, report.segments.is_empty()) {
        (true, _) => table.line("motion", "none: nothing to tell apart"),
        (false, true) => table.line("motion", "none that keeps the bounds tells more"),
        (false, false) => {
            let duration = format!(", {:.1} s", report.duration_s);
            options.files.name("motion", &duration, &mut table);
        }
    }
    table.lines("segments", report.segments.iter().map(segment));
    if !report.sure {
        let (tried, bounded) = (report.candidates, report.bounded);
        table.line(
            "candidates",
            format!("{tried} tried, {bounded} keep the bounds"),
        );
    }
    table.line(
        "entropy",
        format!(
            "{:.2} nats, after the motion {:.2} nats expected",
            report.entropy_before_nats, report.entropy_after_nats
        ),
    );
    table.into_text()
}
