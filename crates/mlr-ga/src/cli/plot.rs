//! Measured against simulated orientation, as a picture.

use anyhow::anyhow;
use mlr_ga::{ComparedSignals, Identification};
use plotters::prelude::*;

const SIZE: (u32, u32) = (900, 640);
const MEASURED: RGBColor = RGBColor(0x1f, 0x4e, 0x79);
const SIMULATED: RGBColor = RGBColor(0xd9, 0x6b, 0x0b);

/// The picture as SVG.
pub(super) fn svg(identification: &Identification) -> anyhow::Result<String> {
    let mut svg = String::new();
    draw(&mut svg, identification).map_err(|error| anyhow!("cannot draw the plot: {error}"))?;
    Ok(svg)
}

fn draw(
    svg: &mut String,
    identification: &Identification,
) -> Result<(), Box<dyn std::error::Error>> {
    let signals = &identification.signals;
    let picture = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    picture.fill(&WHITE)?;
    let title = format!(
        "{} (mean error {:.2}°)",
        identification.description, identification.mean_error_deg
    );
    let picture = picture.titled(&title, ("sans-serif", 20))?;
    let rows = picture.split_evenly((3, 1));
    let axes = [
        ("roll [°]", &signals.measured.roll, &signals.simulated.roll),
        (
            "pitch [°]",
            &signals.measured.pitch,
            &signals.simulated.pitch,
        ),
        ("yaw [°]", &signals.measured.yaw, &signals.simulated.yaw),
    ];
    for (index, (row, (name, measured, simulated))) in rows.iter().zip(axes).enumerate() {
        let is_last = index == 2;
        draw_axis(row, name, measured, simulated, signals, index == 0, is_last)?;
    }
    picture.present()?;
    Ok(())
}

fn draw_axis(
    row: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    name: &str,
    measured_rad: &[f64],
    simulated_rad: &[f64],
    signals: &ComparedSignals,
    with_legend: bool,
    with_time: bool,
) -> Result<(), Box<dyn std::error::Error>> {
    let points = |angles_rad: &[f64]| -> Vec<(f64, f64)> {
        angles_rad
            .iter()
            .enumerate()
            .map(|(q, angle)| (q as f64 / signals.rate_hz, angle.to_degrees()))
            .collect()
    };
    let both = measured_rad.iter().chain(simulated_rad);
    let (low, high) = both.fold((-0.5, 0.5), |(low, high): (f64, f64), angle| {
        (low.min(angle.to_degrees()), high.max(angle.to_degrees()))
    });
    let margin = 0.05 * (high - low);
    let end_s = measured_rad.len() as f64 / signals.rate_hz;
    let mut chart = ChartBuilder::on(row)
        .margin(6)
        .y_label_area_size(60)
        .x_label_area_size(if with_time { 40 } else { 16 })
        .build_cartesian_2d(0.0..end_s, low - margin..high + margin)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .y_desc(name)
        .x_desc(if with_time {
            "time since the start of the walk [s]"
        } else {
            ""
        })
        .label_style(("sans-serif", 13))
        .draw()?;
    for (label, color, angles_rad) in [
        ("measured", MEASURED, measured_rad),
        ("simulated", SIMULATED, simulated_rad),
    ] {
        chart
            .draw_series(LineSeries::new(points(angles_rad), color.stroke_width(2)))?
            .label(label)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2)));
    }
    if with_legend {
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK.mix(0.2))
            .label_font(("sans-serif", 13))
            .draw()?;
    }
    Ok(())
}
