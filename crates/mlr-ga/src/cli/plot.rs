//! Plots of results that commands write as SVG.

use mlr_filter::OrientationSeries;
use mlr_ga::{ComparedSignals, Detection};
use mlr_report::{
    Curve, Figure, Ink, Panel,
    plots::{self, DetectorRun},
};
use mlr_residual::servo::{ServoExplanation, ServoRecording};

use super::output::file_name;

/// Width of a plot that stands alone, and height of each of its panels.
const WIDTH: u32 = 900;
const PANEL_HEIGHT: u32 = 213;

/// Measured and simulated roll, pitch and yaw.
pub(super) fn signals(
    name: &str,
    mean_error_deg: f64,
    signals: &ComparedSignals,
) -> anyhow::Result<String> {
    let title = format!("{name} (mean error {mean_error_deg:.2}°)");
    let both = [&signals.measured, &signals.simulated].map(|angles| (angles, signals.rate_hz));
    alone(plots::signals("signals", &title, both))
}

/// Roll, pitch and yaw, and the fluctuation that the detector saw, with its threshold and flag.
pub(super) fn detection(
    detection: &Detection,
    orientation: &OrientationSeries,
) -> anyhow::Result<String> {
    alone(plots::detector(
        "detector",
        &detector_run(detection, orientation),
    ))
}

/// What the detector made of a log.
pub(super) fn detector_run<'a>(
    detection: &'a Detection,
    orientation: &'a OrientationSeries,
) -> DetectorRun<'a> {
    DetectorRun {
        orientation,
        assessments: &detection.assessments,
        threshold_deg: detection.threshold_deg,
        max_fluctuation_deg: detection.max_fluctuation_deg,
        motion_start_s: detection.motion_start_s,
        damage_s: detection.damage_s,
    }
}

/// Goal, reported angle, and what the servo as described and the one with its effects would report, a
/// row for each recording.
pub(super) fn servo(
    recordings: &[&ServoRecording],
    found: &ServoExplanation,
) -> anyhow::Result<String> {
    let each = recordings.iter().zip(&found.signals).zip(&found.recordings);
    let panels = each.map(|((recording, signals), error)| {
        let curve = |name, ink, angles_rad: &[f64]| {
            let angles_deg = angles_rad.iter().map(|angle| angle.to_degrees());
            let points = recording.times_s.iter().copied().zip(angles_deg);
            Curve::line(name, ink, points.collect())
        };
        let name = file_name(&recording.name);
        let name = name.split('.').next().unwrap_or_default();
        let seen = if error.fitted { "fitted" } else { "unseen" };
        Panel {
            shows: [-0.5, 0.5],
            ..Panel::new(
                format!("{name}, {seen} [°]"),
                vec![
                    curve("goal", Ink::Muted, &recording.goals_rad),
                    curve("before", Ink::Simulated, &signals.before_rad),
                    curve("measured", Ink::Measured, &recording.positions_rad),
                    curve("after", Ink::Alarm, &signals.after_rad),
                ],
            )
        }
    });
    alone(Figure {
        name: "servo".into(),
        title: "the servo before and after".into(),
        description:
            "One panel for each recording: goal, measured angle, and the angles of the servo \
                      as described and with its effects."
                .into(),
        is_headed: false,
        x_label: "time of the recording [s]".into(),
        x_shows: Vec::new(),
        panels: panels.collect(),
        size: [WIDTH, PANEL_HEIGHT],
    })
}

/// A figure that stands alone: wide, with its title.
fn alone(figure: Figure) -> anyhow::Result<String> {
    // Three panels fill the usual size.
    let panels = figure.panels.len().max(3) as u32;
    let picture = Figure {
        is_headed: true,
        size: [WIDTH, PANEL_HEIGHT * panels],
        ..figure
    }
    .draw()?;
    Ok(picture.svg().into())
}
