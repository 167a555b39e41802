//! The page.

mod explanation;
mod identification;
mod missing;

use askama::Template;

use crate::{
    Ink, Picture,
    answer::{LogQuality, Severity},
    report::{Plots, Report, WalkPlots},
    words::percent,
};
use explanation::ExplanationView;
use identification::IdentificationView;
use missing::Missing;

/// Colours on a dark screen, in the order of [`Ink::ALL`]: each has a contrast of at least 4.5 to the
/// background, except the grid's.
const ON_DARK: [&str; 7] = [
    "#5CB3EC", "#FF9A4D", "#3FCF9F", "#FF7AA8", "#9AA5B4", "#E6E9EE", "#2E3742",
];

#[derive(Template)]
#[template(path = "page.html")]
struct Page<'a> {
    title: &'a str,
    inks: Vec<InkView>,
    robot: &'a str,
    identification: IdentificationView,
    plots: &'a Plots,
    walks: Vec<WalkView<'a>>,
    explanation: Option<ExplanationView>,
    footfalls: Option<FootfallsView<'a>>,
    missing: Vec<Missing>,
    manifest: Vec<(&'static str, String)>,
}

struct InkView {
    name: &'static str,
    light: String,
    dark: &'static str,
}

struct WalkView<'a> {
    log: &'a str,
    /// Of several logs, which.
    number: Option<usize>,
    plots: &'a WalkPlots,
    window: String,
    error: String,
    fit: String,
    detector: String,
    quality: Vec<(&'static str, String)>,
    findings: Vec<FindingView>,
    warnings: Vec<&'a str>,
}

struct FindingView {
    severity: &'static str,
    stretch: String,
    reason: String,
}

struct FootfallsView<'a> {
    gait: &'a str,
    cycle_s: f64,
    plot: &'a Picture,
}

pub(crate) fn page(report: &Report<'_>, plots: &Plots) -> Result<String, askama::Error> {
    let inks = Ink::ALL.iter().zip(ON_DARK);
    let footfalls = report.footfalls.as_ref().zip(plots.footfalls.as_ref());
    let walks = report.walks.iter().zip(&plots.walks).enumerate();
    let page = Page {
        title: report.walks.first().map_or("", |walk| &walk.log),
        inks: inks
            .map(|(ink, dark)| InkView {
                name: ink.css_name(),
                light: ink.hex(),
                dark,
            })
            .collect(),
        robot: report.robot.name(),
        identification: IdentificationView::of(report),
        plots,
        walks: walks
            .map(|(index, (_, plots))| WalkView::of(report, index, plots))
            .collect(),
        explanation: report
            .explanation
            .map(|one| ExplanationView::of(one, report.robot)),
        footfalls: footfalls.map(|(footfalls, plot)| FootfallsView {
            gait: &footfalls.gait,
            cycle_s: footfalls.cycle_s,
            plot,
        }),
        missing: missing(report),
        manifest: manifest(report),
    };
    page.render()
}

pub(crate) use missing::of as missing;

impl<'a> WalkView<'a> {
    fn of(report: &'a Report<'_>, index: usize, plots: &'a WalkPlots) -> Self {
        let walk = &report.walks[index];
        let found = report.identification;
        let of_log = found.logs.get(index);
        let (fit, quality) = match of_log {
            Some(log) => (&log.fit, &log.log_quality),
            None => (&found.fit, &found.log_quality),
        };
        let [start_s, length_s] = found.window_s(index);
        let warnings = of_log.map_or(&found.warnings, |log| &log.warnings);
        let [roll, pitch, yaw] = fit.error_deg;
        let detector = match &walk.detector {
            Err(reason) => format!("Not computed: {reason}."),
            Ok(run) => {
                let most = run.max_fluctuation_deg;
                let flag = match run.damage_s {
                    Some(damage_s) => format!("Damage was flagged at {damage_s:.2} s"),
                    None => "No damage was flagged".into(),
                };
                format!(
                    "{flag}. Roll or pitch fluctuated by up to {most:.1}° within the detector's \
                     window; a healthy robot stays below {:.1}°.",
                    run.threshold_deg
                )
            }
        };
        Self {
            log: &walk.log,
            number: (report.walks.len() > 1).then_some(index + 1),
            plots,
            window: format!("{length_s:.1} s from {start_s:.2} s on"),
            error: format!("{:.2}°", walk.error_deg),
            fit: format!(
                "Root mean square of what is left without means and trends: {roll:.2}° of roll, \
                 {pitch:.2}° of pitch, {yaw:.2}° of yaw, with {}.",
                varied(fit)
            ),
            detector,
            quality: quality_rows(quality),
            findings: quality
                .findings
                .iter()
                .map(|finding| FindingView {
                    severity: match finding.severity {
                        Severity::Useless => "useless there",
                        Severity::Worse => "may mislead",
                        Severity::Note => "note",
                    },
                    stretch: format!("{:.2} to {:.2} s", finding.from_s, finding.to_s),
                    reason: match &finding.cure {
                        Some(cure) => format!("{}; try {cure}", finding.reason),
                        None => finding.reason.clone(),
                    },
                })
                .collect(),
            warnings: warnings.iter().map(String::as_str).collect(),
        }
    }
}

/// By what the model that fits best differs from the nominal one.
fn varied(fit: &crate::answer::Fit) -> String {
    let mut parts = Vec::new();
    let mut share = |name: &str, over_nominal: f64| {
        if (over_nominal - 1.0).abs() > 1e-9 {
            parts.push(format!("{name} × {over_nominal:.2}"));
        }
    };
    share("friction", fit.friction);
    share("stiffness of the servos", fit.stiffness);
    share("duration of the gait", 1.0 + fit.clock);
    if fit.payload > 0.0 {
        parts.push(format!(
            "a payload of {:.0} % of the body",
            100.0 * fit.payload
        ));
    }
    if fit.slope_deg != 0.0 {
        parts.push(format!("a slope of {:.1}°", fit.slope_deg));
    }
    if fit.delay_s != 0.0 {
        parts.push(format!("a delay of {:.0} ms", 1e3 * fit.delay_s));
    }
    match parts.len() {
        0 => "the nominal model".into(),
        _ => parts.join(", "),
    }
}

fn quality_rows(quality: &LogQuality) -> Vec<(&'static str, String)> {
    let mut rows = vec![
        ("rows", format!("{:.0} per second", quality.sample_rate_hz)),
        (
            "values change",
            format!("{:.0} times a second", quality.value_rate_hz),
        ),
    ];
    if let Some(gravity_mps2) = quality.gravity_mps2 {
        rows.push(("gravity", format!("{gravity_mps2:.2} m/s²")));
    }
    rows
}

fn manifest(report: &Report<'_>) -> Vec<(&'static str, String)> {
    let made = &report.manifest;
    let found = report.identification;
    let mut rows = vec![
        ("program", made.program.clone()),
        ("identification", made.identification.clone()),
        (
            "decided by",
            match found.method.as_str() {
                "paper" => "the paper's method: the least F".into(),
                "mlr" => "the posterior probability".into(),
                other => other.into(),
            },
        ),
        ("seed", found.seed.to_string()),
        (
            "robot",
            match &made.robot_file {
                Some(file) => format!("{} ({file})", report.robot.name()),
                None => format!("{} (embedded)", report.robot.name()),
            },
        ),
        (
            "calibration",
            match report.robot.calibration() {
                Some(calibration) => format!(
                    "the robot's own: {} parameters learned",
                    calibration.parameters().len()
                ),
                None => "none: the robot as its make is described".into(),
            },
        ),
    ];
    for walk in &report.walks {
        let hash = walk.sha256.as_deref();
        rows.push(("log", walk.log.clone()));
        rows.push(("gait", walk.gait.name.clone()));
        rows.push((
            "SHA-256 of the log",
            hash.unwrap_or("not known: it was read from standard input")
                .into(),
        ));
    }
    rows
}

/// A probability with the width of its bar.
struct Share {
    text: String,
    percent: f64,
}

impl Share {
    fn of(probability: f64) -> Self {
        Self {
            text: percent(probability),
            percent: 100.0 * probability.clamp(0.0, 1.0),
        }
    }
}
