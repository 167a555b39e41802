use ratatui::{
    Frame,
    layout::Rect,
    widgets::{Sparkline, SparklineBar},
};

use super::Palette;
use crate::top::picture::Picture;

/// Columns to the right of the course, in which the threshold is written.
const SCALE_COLUMNS: u16 = 7;
/// Bars are as high as the area at this multiple of the threshold, or higher where they swing more.
const LEAST_TOP: f64 = 2.0;

/// Seconds that are shown in so many columns.
fn shown(picture: &Picture, columns: u16) -> usize {
    picture.fluctuations_deg.len().min(columns.into())
}

pub(super) fn heading(picture: &Picture, width: u16) -> String {
    let status = &picture.status;
    let mut heading = "Roll or pitch swing".to_owned();
    if let Some(now_deg) = status.fluctuation_deg {
        heading += &format!(" by {now_deg:.1}°");
    }
    if let Some(threshold_deg) = status.threshold_deg {
        heading += &format!(", threshold {threshold_deg:.1}°");
    }
    match shown(picture, width.saturating_sub(SCALE_COLUMNS)) {
        0 => heading + ": no course told yet",
        seconds => heading + &format!(", last {seconds} s"),
    }
}

/// A bar for each second, the newest at the right, and a line at the threshold.
pub(super) fn draw(frame: &mut Frame, area: Rect, picture: &Picture, palette: Palette) {
    let columns = area.width.saturating_sub(SCALE_COLUMNS);
    let seconds = shown(picture, columns);
    if seconds == 0 || area.height == 0 {
        return;
    }
    let skipped = picture.fluctuations_deg.len() - seconds;
    let course_deg = picture.fluctuations_deg.iter().skip(skipped);
    let threshold_deg = picture.status.threshold_deg;
    let largest_deg = course_deg.clone().copied().fold(0.0, f64::max);
    let top_deg = largest_deg
        .max(threshold_deg.unwrap_or(0.0) * LEAST_TOP)
        .max(1e-3);
    let is_above = |deg: f64| threshold_deg.is_some_and(|threshold_deg| deg > threshold_deg);
    // Whole numbers are wanted: thousandths of a degree.
    let millidegrees = |deg: f64| (deg * 1000.0).round() as u64;
    let bars = course_deg.map(|&deg| {
        SparklineBar::from(millidegrees(deg)).style(palette.fluctuation(is_above(deg)))
    });
    let course = Rect {
        x: area.x + columns - seconds as u16,
        width: seconds as u16,
        ..area
    };
    let sparkline = Sparkline::default()
        .data(bars.collect::<Vec<_>>())
        .max(millidegrees(top_deg));
    frame.render_widget(sparkline, course);
    let scale_x = area.x + columns + 1;
    let last = area.width.saturating_sub(columns + 1);
    let buffer = frame.buffer_mut();
    if let Some(threshold_deg) = threshold_deg {
        let from_top = (1.0 - threshold_deg / top_deg) * f64::from(area.height);
        let line = area.y + (from_top as u16).min(area.height - 1);
        for x in area.x..area.x + columns {
            if let Some(cell) = buffer.cell_mut((x, line))
                && cell.symbol() == " "
            {
                cell.set_symbol("╌").set_style(palette.quiet());
            }
        }
        let text = format!("{threshold_deg:.1}°");
        buffer.set_stringn(scale_x, line, text, last.into(), palette.quiet());
        if line == area.y {
            return;
        }
    }
    let text = format!("{top_deg:.1}°");
    buffer.set_stringn(scale_x, area.y, text, last.into(), palette.quiet());
}
