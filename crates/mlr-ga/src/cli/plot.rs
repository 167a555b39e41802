//! Pictures of results, as SVG.

use std::error::Error;

use anyhow::anyhow;
use mlr_filter::OrientationSeries;
use mlr_ga::{ComparedSignals, Detection};
use mlr_residual::servo::{ServoExplanation, ServoRecording};
use plotters::{coord::Shift, prelude::*};

use super::output::file_name;

const SIZE: (u32, u32) = (900, 640);
const MEASURED: RGBColor = RGBColor(0x1f, 0x4e, 0x79);
const SIMULATED: RGBColor = RGBColor(0xd9, 0x6b, 0x0b);
const GOAL: RGBColor = RGBColor(0x9a, 0x9a, 0x9a);
const ALARM: RGBColor = RGBColor(0xb0, 0x1e, 0x2e);
const FONT: &str = "sans-serif";

type Drawn = Result<(), Box<dyn Error>>;
type Row<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// A curve of (time in s, degrees), with its name in the legend.
struct Curve {
    name: &'static str,
    color: RGBColor,
    points: Vec<(f64, f64)>,
}

/// Measured and simulated roll, pitch and yaw.
pub(super) fn signals(
    name: &str,
    mean_error_deg: f64,
    signals: &ComparedSignals,
) -> anyhow::Result<String> {
    let title = format!("{name} (mean error {mean_error_deg:.2}°)");
    let curve = |name, color, angles_rad: &[f64]| Curve {
        name,
        color,
        points: angles_rad
            .iter()
            .enumerate()
            .map(|(q, angle)| (q as f64 / signals.rate_hz, angle.to_degrees()))
            .collect(),
    };
    let (measured, simulated) = (&signals.measured, &signals.simulated);
    let rows = [
        ("roll [°]", &measured.roll, &simulated.roll),
        ("pitch [°]", &measured.pitch, &simulated.pitch),
        ("yaw [°]", &measured.yaw, &simulated.yaw),
    ]
    .map(|(axis, measured, simulated)| {
        let curves = vec![
            curve("measured", MEASURED, measured),
            curve("simulated", SIMULATED, simulated),
        ];
        (axis, curves)
    });
    picture(
        &title,
        "time since the start of the walk [s]",
        &rows,
        |_, _| Ok(()),
    )
}

/// Roll, pitch and yaw, and the fluctuation that the detector saw, with its threshold and flag.
pub(super) fn detection(
    detection: &Detection,
    orientation: &OrientationSeries,
) -> anyhow::Result<String> {
    let title = match detection.damage_s {
        Some(damage_s) => format!("damage flagged at {damage_s:.1} s"),
        None => "no damage flagged".into(),
    };
    let angles = orientation.angles_rad();
    let curve = |name, color, angles_rad: &[f64]| {
        // More points than pixels tell nothing.
        let step = angles_rad.len().div_ceil(4 * SIZE.0 as usize).max(1);
        let times_s = orientation.times_s().iter();
        let points = times_s.zip(angles_rad).step_by(step);
        Curve {
            name,
            color,
            points: points.map(|(t, angle)| (*t, angle.to_degrees())).collect(),
        }
    };
    let fluctuation = Curve {
        name: "fluctuation",
        color: MEASURED,
        points: detection
            .assessments
            .iter()
            .map(|one| (one.time_s, one.fluctuation_deg))
            .collect(),
    };
    let ends_s = fluctuation.points.first().zip(fluctuation.points.last());
    let threshold = Curve {
        name: "threshold",
        color: SIMULATED,
        points: ends_s.map_or_else(Vec::new, |(first, last)| {
            [first.0, last.0]
                .map(|t| (t, detection.threshold_deg))
                .into()
        }),
    };
    let rows = [
        (
            "roll, pitch [°]",
            vec![
                curve("roll", MEASURED, &angles.roll),
                curve("pitch", SIMULATED, &angles.pitch),
            ],
        ),
        ("yaw [°]", vec![curve("yaw", MEASURED, &angles.yaw)]),
        ("fluctuation [°]", vec![fluctuation, threshold]),
    ];
    let marks: Vec<(f64, RGBColor)> = [
        detection.motion_start_s.map(|t| (t, SIMULATED)),
        detection.damage_s.map(|t| (t, ALARM)),
    ]
    .into_iter()
    .flatten()
    .collect();
    picture(
        &title,
        "time of the log [s]",
        &rows,
        |chart, (low, high)| {
            for (time_s, color) in &marks {
                let line = [(*time_s, low), (*time_s, high)];
                chart.draw_series(LineSeries::new(line, color.stroke_width(2)))?;
            }
            Ok(())
        },
    )
}

/// Goal, reported angle, and what the servo as described and the one with its effects would report, a
/// row for each recording.
pub(super) fn servo(
    recordings: &[&ServoRecording],
    found: &ServoExplanation,
) -> anyhow::Result<String> {
    let each = recordings.iter().zip(&found.signals).zip(&found.recordings);
    let rows: Vec<(String, Vec<Curve>)> = each
        .map(|((recording, signals), error)| {
            let curve = |name, color, angles_rad: &[f64]| Curve {
                name,
                color,
                points: recording
                    .times_s
                    .iter()
                    .copied()
                    .zip(degrees(angles_rad))
                    .collect(),
            };
            let name = file_name(&recording.name);
            let name = name.split('.').next().unwrap_or_default();
            let seen = if error.fitted { "fitted" } else { "unseen" };
            let curves = vec![
                curve("goal", GOAL, &recording.goals_rad),
                curve("before", SIMULATED, &signals.before_rad),
                curve("measured", MEASURED, &recording.positions_rad),
                curve("after", ALARM, &signals.after_rad),
            ];
            (format!("{name}, {seen} [°]"), curves)
        })
        .collect();
    picture(
        "the servo before and after",
        "time of the recording [s]",
        &rows,
        |_, _| Ok(()),
    )
}

fn degrees(angles_rad: &[f64]) -> impl Iterator<Item = f64> {
    angles_rad.iter().map(|angle| angle.to_degrees())
}

type Chart<'a, 'b> = ChartContext<
    'a,
    SVGBackend<'b>,
    Cartesian2d<plotters::coord::types::RangedCoordf64, plotters::coord::types::RangedCoordf64>,
>;

/// Rows of curves over one time axis. `mark` draws on each row, whose lowest and highest angle
/// it is given.
fn picture(
    title: &str,
    time_axis: &str,
    rows: &[(impl AsRef<str>, Vec<Curve>)],
    mark: impl Fn(&mut Chart<'_, '_>, (f64, f64)) -> Drawn,
) -> anyhow::Result<String> {
    let mut svg = String::new();
    // Three rows fill the usual size.
    let size = (SIZE.0, SIZE.1 * rows.len().max(3) as u32 / 3);
    let mut draw = || -> Drawn {
        let picture = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        picture.fill(&WHITE)?;
        let picture = picture.titled(title, (FONT, 20))?;
        let areas = picture.split_evenly((rows.len(), 1));
        for (index, (area, (axis, curves))) in areas.iter().zip(rows).enumerate() {
            let time_axis = (index + 1 == rows.len()).then_some(time_axis);
            draw_row(area, axis.as_ref(), curves, time_axis, &mark)?;
        }
        picture.present()?;
        Ok(())
    };
    draw().map_err(|error| anyhow!("cannot draw the plot: {error}"))?;
    Ok(svg)
}

fn draw_row(
    area: &Row<'_>,
    axis: &str,
    curves: &[Curve],
    time_axis: Option<&str>,
    mark: impl Fn(&mut Chart<'_, '_>, (f64, f64)) -> Drawn,
) -> Drawn {
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let (low, high) = points().fold((-0.5, 0.5), |(low, high): (f64, f64), point| {
        (low.min(point.1), high.max(point.1))
    });
    let margin = 0.05 * (high - low);
    let (low, high) = (low - margin, high + margin);
    let from_s = points().map(|point| point.0).fold(f64::INFINITY, f64::min);
    let to_s = points()
        .map(|point| point.0)
        .fold(f64::NEG_INFINITY, f64::max);
    let mut chart = ChartBuilder::on(area)
        .margin(6)
        .y_label_area_size(60)
        .x_label_area_size(if time_axis.is_some() { 40 } else { 16 })
        .build_cartesian_2d(from_s..to_s, low..high)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .y_desc(axis)
        .x_desc(time_axis.unwrap_or_default())
        .label_style((FONT, 13))
        .draw()?;
    for curve in curves {
        let color = curve.color;
        chart
            .draw_series(LineSeries::new(
                curve.points.iter().copied(),
                color.stroke_width(2),
            ))?
            .label(curve.name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2)));
    }
    mark(&mut chart, (low, high))?;
    if curves.len() > 1 {
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK.mix(0.2))
            .label_font((FONT, 13))
            .draw()?;
    }
    Ok(())
}
