use ratatui::{
    Frame,
    layout::Rect,
    style::{Modifier, Style},
    text::{Line, Span},
    widgets::Paragraph,
};

use super::{Palette, View};
use crate::{
    event::Level,
    top::{picture::Picture, saying},
};

/// Columns of the words that head a line.
const LABEL: usize = 12;
/// Lines that one conclusion may take.
const MOST_LINES: usize = 3;

/// How the sensor is.
pub(super) fn sensor(picture: &Picture, palette: Palette) -> Vec<Line<'_>> {
    let status = &picture.status;
    let port = picture.port.as_deref().unwrap_or("not told yet");
    let mut lines = vec![labelled("port", port, Style::new())];
    if status.state.is_empty() {
        lines.push(labelled("rate", "not told yet", Style::new()));
    } else {
        let style = match status.silent_s > 2.0 {
            true => palette.of_level(Level::Stale),
            false => Style::new(),
        };
        lines.push(labelled("rate", &saying::rate(status), style));
        let (good, bad, lost) = (status.good, status.bad, status.lost);
        let frames = format!("{good}, {bad} bad, {lost} lost");
        lines.push(labelled("frames", &frames, Style::new()));
        let angle = |angle_deg: Option<f64>| match angle_deg {
            Some(angle_deg) => format!("{angle_deg:.1}°"),
            None => "–".into(),
        };
        let tilt = format!(
            "roll {}, pitch {}",
            angle(status.roll_deg),
            angle(status.pitch_deg)
        );
        lines.push(labelled("body", &tilt, Style::new()));
    }
    if status.dropped_status + status.dropped_events > 0 {
        let (status, events) = (status.dropped_status, status.dropped_events);
        let dropped = format!("{status} status, {events} events");
        lines.push(labelled("dropped", &dropped, palette.warning()));
    }
    let health = if let Some(reason) = &picture.port_lost {
        labelled("health", reason, palette.of_level(Level::Stale))
    } else if let Some(reason) = &picture.line_fault {
        labelled("health", reason, palette.of_level(Level::Error))
    } else if let Some((fault, reason)) = &picture.sensor_fault {
        let text = format!("{fault} {reason}");
        labelled("health", text.trim_end(), palette.of_level(Level::Error))
    } else if status.state.is_empty() {
        labelled("health", "not told yet", Style::new())
    } else {
        labelled("health", "no fault", Style::new())
    };
    lines.push(health);
    lines
}

fn labelled<'a>(label: &'a str, text: &str, style: Style) -> Line<'a> {
    Line::from(vec![
        Span::raw(format!("{label:<8}")),
        Span::styled(text.to_owned(), style),
    ])
}

/// What the daemon found out, in lines of so many columns.
pub(super) fn found(picture: &Picture, palette: Palette, columns: u16) -> Vec<Line<'static>> {
    let mut lines = Vec::new();
    let found = [
        ("damage", &picture.damage),
        ("explained", &picture.explanation),
        ("recovery", &picture.recovery),
        ("calibrated", &picture.calibration),
        ("corrected", &picture.correction),
    ];
    for (label, finding) in found {
        let Some(finding) = finding else { continue };
        let style = palette.of_level(finding.level);
        let room = usize::from(columns).saturating_sub(LABEL);
        for (index, part) in wrapped(&finding.text, room).into_iter().enumerate() {
            let label = if index == 0 { label } else { "" };
            lines.push(Line::from(vec![
                Span::raw(format!("{label:<LABEL$}")),
                Span::styled(part, style),
            ]));
        }
    }
    if lines.is_empty() {
        lines.push(Line::raw("nothing yet"));
    }
    lines
}

/// The text in lines of so many characters, broken between words where there are any.
fn wrapped(text: &str, columns: usize) -> Vec<String> {
    let columns = columns.max(1);
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        let word_length = word.chars().count();
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word_length <= columns => {
                line.push(' ');
                line.push_str(word);
            }
            _ => {
                let letters: Vec<char> = word.chars().collect();
                let pieces = letters.chunks(columns).map(|piece| piece.iter().collect());
                lines.extend(pieces);
            }
        }
    }
    if lines.len() > MOST_LINES {
        lines.truncate(MOST_LINES);
        if let Some(last) = lines.last_mut() {
            let room = columns.saturating_sub(2);
            *last = last.chars().take(room).collect::<String>() + " …";
        }
    }
    lines
}

/// The last events that fit, the newest at the bottom.
pub(super) fn draw_events(frame: &mut Frame, area: Rect, picture: &Picture, view: &View) {
    let scrolled_back = view.scrolled_back.min(picture.entries.len());
    let newest = picture.entries.len() - scrolled_back;
    let oldest = newest.saturating_sub(area.height.into());
    let lines = picture.entries.range(oldest..newest).map(|entry| {
        let Some((time, _, level)) = &entry.event else {
            return Line::styled(entry.text.as_str(), Modifier::DIM);
        };
        let style = view.palette.of_level(*level);
        Line::from(vec![
            Span::raw(format!("{:8} ", saying::time_of_day(time))),
            Span::styled(format!("{:<6}", saying::level(*level)), style),
            Span::raw(entry.text.as_str()),
        ])
    });
    frame.render_widget(Paragraph::new(lines.collect::<Vec<_>>()), area);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_broken_between_words_and_shortened() {
        assert_eq!(wrapped("leg 3 lost", 6), ["leg 3", "lost"]);
        assert_eq!(wrapped("abcdefgh", 3), ["abc", "def", "gh"]);
        assert_eq!(wrapped("a b c d e", 3), ["a b", "c d", "e"]);
        assert_eq!(wrapped("aa bb cc dd", 2), ["aa", "bb", " …"]);
        assert!(wrapped("", 5).is_empty());
    }
}
