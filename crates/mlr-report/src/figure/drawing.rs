//! By plotters.

use std::error::Error;

use plotters::{
    coord::{Shift, types::RangedCoordf64},
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};

use super::{Curve, Figure, Ink, Mark, Panel, Rule};
use crate::{Picture, PictureError};

/// Coordinates of plotters are whole numbers: so many of them make a pixel.
const FINE: u32 = 4;
const FONT: &str = "sans-serif";
/// Sizes of fonts in plotters are so many times those in its SVG.
const FONT_UNIT: f64 = 1.24;
const FONT_SIZE: u32 = 13;
const HEADING_SIZE: u32 = 17;
/// Height of the strips above and below the panels.
const HEADING: u32 = 30;
const LEGEND: u32 = 24;
const X_AXIS: u32 = 42;
const X_TICKS: u32 = 22;
const Y_AXIS: u32 = 58;
const MARGIN: u32 = 6;

type Drawn<T = ()> = Result<T, Box<dyn Error>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

pub(super) fn draw(figure: &Figure) -> Result<Picture, PictureError> {
    let finite = |curve: &Curve| {
        let mut points = curve.points.iter();
        points.all(|(x, y)| x.is_finite() && y.is_finite())
    };
    if !figure.panels.iter().flat_map(|one| &one.curves).all(finite) {
        return Err(PictureError::Chart {
            title: figure.title.clone(),
            reason: "a coordinate is not finite".into(),
        });
    }
    let mut svg = String::new();
    let fine = figure.size.map(|pixels| pixels * FINE);
    draw_into(figure, SVGBackend::with_string(&mut svg, fine.into())).map_err(|error| {
        PictureError::Chart {
            title: figure.title.clone(),
            reason: error.to_string(),
        }
    })?;
    // The outermost element is the first line, and is ours to write.
    let content = svg.split_once('\n').map_or("", |(_, rest)| rest);
    let content = content.trim_end().trim_end_matches("</svg>");
    Ok(Picture::new(
        &figure.name,
        &figure.title,
        &figure.description,
        figure.size,
        fine,
        content,
    ))
}

fn color(ink: Ink) -> RGBColor {
    let [r, g, b] = ink.rgb();
    RGBColor(r, g, b)
}

fn text(size: u32, ink: Ink) -> TextStyle<'static> {
    let size = FONT_UNIT * f64::from(size * FINE);
    (FONT, size).into_font().color(&color(ink))
}

fn line(ink: Ink, width: u32) -> ShapeStyle {
    color(ink).stroke_width(width * FINE / 2)
}

fn draw_into(figure: &Figure, backend: SVGBackend<'_>) -> Drawn {
    let mut rest = backend.into_drawing_area();
    if figure.is_headed {
        let (heading, below) = rest.split_vertically(HEADING * FINE);
        let centered = text(HEADING_SIZE, Ink::Text).pos(Pos::new(HPos::Center, VPos::Center));
        let (width, height) = heading.dim_in_pixel();
        let middle = (width as i32 / 2, height as i32 / 2);
        heading.draw(&Text::new(figure.title.clone(), middle, centered))?;
        rest = below;
    }
    if has_legend(figure) {
        let (legend, below) = rest.split_vertically(LEGEND * FINE);
        draw_legend(figure, &legend)?;
        rest = below;
    }
    let curves = figure.panels.iter().flat_map(|one| &one.curves);
    let xs = curves.flat_map(|curve| curve.points.iter().map(|point| point.0));
    let x_range = range(xs.chain(figure.x_shows.iter().copied()), None);
    let panels = figure.panels.len().max(1) as i32;
    let height = (rest.dim_in_pixel().1 - (X_AXIS - X_TICKS) * FINE) as i32 / panels;
    let breaks: Vec<i32> = (1..panels).map(|panel| panel * height).collect();
    let none: [i32; 0] = [];
    let areas = rest.split_by_breakpoints(none, &breaks);
    for (index, (area, panel)) in areas.iter().zip(&figure.panels).enumerate() {
        let is_last = index + 1 == figure.panels.len();
        let x_label = is_last.then_some(figure.x_label.as_str());
        draw_panel(area, panel, &x_range, x_label)?;
    }
    rest.present()?;
    Ok(())
}

/// Names and inks of the curves, each once.
fn entries(figure: &Figure) -> Vec<(&'static str, Ink)> {
    let mut entries = Vec::new();
    for curve in figure.panels.iter().flat_map(|panel| &panel.curves) {
        let entry = (curve.name, curve.ink);
        if !curve.name.is_empty() && !entries.contains(&entry) {
            entries.push(entry);
        }
    }
    entries
}

fn has_legend(figure: &Figure) -> bool {
    entries(figure).len() > 1
}

fn draw_legend(figure: &Figure, area: &Area<'_>) -> Drawn {
    const SAMPLE: i32 = 18;
    const GAP: i32 = 16;
    let fine = FINE as i32;
    let middle = (LEGEND * FINE) as i32 / 2;
    let mut x = (Y_AXIS * FINE) as i32;
    for (name, ink) in entries(figure) {
        let sample = [(x, middle), (x + SAMPLE * fine, middle)];
        area.draw(&PathElement::new(sample, line(ink, 6)))?;
        x += (SAMPLE + 5) * fine;
        let style = text(FONT_SIZE, Ink::Text).pos(Pos::new(HPos::Left, VPos::Center));
        area.draw(&Text::new(name, (x, middle), style))?;
        // About as wide as letters are in any font.
        x += (name.chars().count() as f64 * 0.56 * f64::from(FONT_SIZE * FINE)) as i32 + GAP * fine;
    }
    Ok(())
}

/// From the least to the greatest value; something where there is none, or one.
fn range(values: impl Iterator<Item = f64>, shows: Option<[f64; 2]>) -> std::ops::Range<f64> {
    let values = values.chain(shows.into_iter().flatten());
    let ends = values.fold(None, |ends: Option<[f64; 2]>, value| {
        let [low, high] = ends.unwrap_or([value; 2]);
        Some([low.min(value), high.max(value)])
    });
    let [low, high] = ends.unwrap_or([0.0, 1.0]);
    if high - low > 1e-9 {
        low..high
    } else {
        low - 0.5..high + 0.5
    }
}

fn draw_panel(
    area: &Area<'_>,
    panel: &Panel,
    x_range: &std::ops::Range<f64>,
    x_label: Option<&str>,
) -> Drawn {
    let levels = panel.rules.iter().filter_map(|rule| match rule {
        Rule::Level(y, ..) => Some(*y),
        Rule::At(..) => None,
    });
    let points = panel.curves.iter().flat_map(|curve| &curve.points);
    let y_range = range(points.map(|point| point.1).chain(levels), Some(panel.shows));
    let room = 0.06 * (y_range.end - y_range.start);
    let y_range = y_range.start - room..y_range.end + room;
    let mut chart = ChartBuilder::on(area)
        .margin(MARGIN * FINE)
        .margin_right(3 * MARGIN * FINE)
        .y_label_area_size((Y_AXIS - MARGIN) * FINE)
        .x_label_area_size(FINE * if x_label.is_some() { X_AXIS } else { X_TICKS } - MARGIN * FINE)
        .build_cartesian_2d(x_range.clone(), y_range.clone())?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(line(Ink::Grid, 2))
        .axis_style(line(Ink::Muted, 2))
        .x_labels(7)
        .y_labels(5)
        .x_label_formatter(&|x| number(*x))
        .y_label_formatter(&|y| number(*y))
        .label_style(text(FONT_SIZE, Ink::Text))
        .axis_desc_style(text(FONT_SIZE, Ink::Text))
        .y_desc(panel.y_label.as_str())
        .x_desc(x_label.unwrap_or_default())
        .set_all_tick_mark_size(4 * FINE)
        .draw()?;
    for rule in &panel.rules {
        draw_rule(&mut chart, rule, x_range, &y_range)?;
    }
    for curve in &panel.curves {
        draw_curve(&mut chart, curve)?;
    }
    Ok(())
}

fn draw_curve(chart: &mut Chart<'_, '_>, curve: &Curve) -> Drawn {
    let points = curve.points.iter().copied();
    if curve.mark == Mark::Line {
        chart.draw_series(LineSeries::new(points, line(curve.ink, 3)))?;
        return Ok(());
    }
    if curve.mark == Mark::Stems {
        let stems = points.clone().map(|(x, y)| {
            let stem = [(x, 0.0), (x, y)];
            PathElement::new(stem, line(curve.ink, 4))
        });
        chart.draw_series(stems)?;
    }
    let filled = color(curve.ink).filled();
    chart.draw_series(points.map(|point| Circle::new(point, 3 * FINE, filled)))?;
    Ok(())
}

fn draw_rule(
    chart: &mut Chart<'_, '_>,
    rule: &Rule,
    x_range: &std::ops::Range<f64>,
    y_range: &std::ops::Range<f64>,
) -> Drawn {
    let (ends, name, ink, at, anchor) = match rule {
        Rule::At(x, ..) if !x_range.contains(x) => return Ok(()),
        Rule::At(x, name, ink) => {
            let is_left = *x < f64::midpoint(x_range.start, x_range.end);
            let side = if is_left { HPos::Left } else { HPos::Right };
            let ends = [(*x, y_range.start), (*x, y_range.end)];
            (
                ends,
                name,
                *ink,
                (*x, y_range.end),
                Pos::new(side, VPos::Top),
            )
        }
        Rule::Level(y, name, ink) => {
            let ends = [(x_range.start, *y), (x_range.end, *y)];
            let at = (x_range.end, *y);
            (ends, name, *ink, at, Pos::new(HPos::Right, VPos::Bottom))
        }
    };
    let dashes = DashedLineSeries::new(ends, 6 * FINE, 4 * FINE, line(ink, 3));
    chart.draw_series(dashes)?;
    let style = text(FONT_SIZE - 1, ink).pos(anchor);
    let beside = match anchor.h_pos {
        HPos::Left => 4 * FINE as i32,
        _ => -4 * FINE as i32,
    };
    let label = EmptyElement::at(at) + Text::new(name.clone(), (beside, 0), style);
    chart.draw_series(std::iter::once(label))?;
    Ok(())
}

/// A number as short as it can be, with a true minus sign.
fn number(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    match text.strip_prefix('-') {
        Some("0") => "0".into(),
        Some(positive) => format!("−{positive}"),
        None => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(points: Vec<(f64, f64)>) -> Figure {
        let rules = vec![
            Rule::Level(0.5, "threshold".into(), Ink::Muted),
            Rule::At(1.0, "flag <&>".into(), Ink::Alarm),
        ];
        Figure {
            name: "test".into(),
            title: "A <title> & \"more\"".into(),
            description: "described".into(),
            is_headed: true,
            x_label: "time [s]".into(),
            x_shows: Vec::new(),
            panels: vec![Panel {
                rules,
                ..Panel::new(
                    "roll [°]",
                    vec![Curve::line("measured", Ink::Measured, points)],
                )
            }],
            size: [480, 300],
        }
    }

    #[test]
    fn a_figure_is_well_formed_and_named_for_those_who_cannot_see_it() {
        let picture = figure(vec![(0.0, 0.0), (1.0, 1.0), (2.0, -1.0)])
            .draw()
            .unwrap();
        let svg = picture.svg();
        assert!(svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"480\""));
        assert!(svg.contains("role=\"img\" aria-labelledby=\"test-title test-desc\""));
        let title = "<title id=\"test-title\">A &#60;title&#62; &#38; &#34;more&#34;</title>";
        assert!(svg.contains(title), "{svg}");
        assert!(svg.trim_end().ends_with("</svg>"));
        assert_eq!(svg.matches("<svg").count(), 1);
        assert!(!svg.contains("<&>"));
        picture.png(1.0).unwrap();
    }

    #[test]
    fn nothing_and_one_point_can_be_drawn_and_infinity_cannot() {
        figure(Vec::new()).draw().unwrap();
        figure(vec![(1.0, 1.0)]).draw().unwrap();
        let error = figure(vec![(0.0, f64::INFINITY)]).draw().unwrap_err();
        assert!(error.to_string().contains("not finite"), "{error}");
    }

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (2.50, "2.5"),
            (-10.0, "−10"),
            (1e-9, "0"),
        ] {
            assert_eq!(number(value), text);
        }
    }
}
