//! The picture as characters.

mod fluctuation;
mod palette;
mod panels;
mod robot;

use std::time::Duration;

use ratatui::{
    Frame,
    layout::{Constraint, Layout, Rect},
    style::Modifier,
    text::{Line, Span},
    widgets::{Block, Borders},
};

pub use palette::Palette;

use super::{picture::Picture, saying};

/// What is shown beside the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Colours or none.
    pub palette: Palette,
    /// Time since the last line of the stream.
    pub silent: Duration,
    /// The stream is at its end.
    pub ended: bool,
    /// By how many lines the list of events was scrolled back.
    pub scrolled_back: usize,
}

/// Silence of the stream that is worth a word: a status comes every ten seconds unless told
/// otherwise.
const SILENT: Duration = Duration::from_secs(15);
/// From this width on the sensor stands beside the robot.
const WIDE: u16 = 78;
/// Columns of the robot in a wide terminal.
const ROBOT_COLUMNS: u16 = 48;
/// Lines of the fluctuation, with its heading.
const FLUCTUATION_LINES: u16 = 5;
/// Lines that the list of events has at least, with its heading.
const EVENT_LINES: u16 = 3;

/// Draws the picture.
pub fn draw(frame: &mut Frame, picture: &Picture, view: &View) {
    let found = panels::found(picture, view.palette, frame.area().width);
    let found_lines = (found.len() as u16 + 1).min(frame.area().height / 3);
    let sensor = panels::sensor(picture, view.palette);
    let robot_lines = robot::lines(picture) + 1;
    let sensor_lines = sensor.len() as u16 + 1;
    let is_wide = frame.area().width >= WIDE;
    let upper_lines = match is_wide {
        true => robot_lines.max(sensor_lines),
        false => robot_lines + sensor_lines,
    };
    let [head, upper, fluctuation, middle, events, foot] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Max(upper_lines),
        Constraint::Max(FLUCTUATION_LINES),
        Constraint::Max(found_lines),
        Constraint::Min(EVENT_LINES),
        Constraint::Length(1),
    ])
    .areas(frame.area());
    let [robot_area, sensor_area] = match is_wide {
        true => Layout::horizontal([Constraint::Length(ROBOT_COLUMNS), Constraint::Min(0)])
            .spacing(2)
            .areas(upper),
        false => {
            Layout::vertical([Constraint::Length(robot_lines), Constraint::Min(0)]).areas(upper)
        }
    };
    frame.render_widget(headline(picture, view), head);
    let name = match picture.robot.name.as_str() {
        "" => "Robot from above",
        name => name,
    };
    let inside = headed(
        frame,
        robot_area,
        &format!("{name}: damage of its legs"),
        view,
    );
    robot::draw(frame, inside, picture, view.palette);
    let inside = headed(frame, sensor_area, "Sensor", view);
    frame.render_widget(ratatui::text::Text::from(sensor), inside);
    let inside = headed(
        frame,
        fluctuation,
        &fluctuation::heading(picture, fluctuation.width),
        view,
    );
    fluctuation::draw(frame, inside, picture, view.palette);
    let inside = headed(frame, middle, "Found", view);
    frame.render_widget(ratatui::text::Text::from(found), inside);
    let heading = match view.scrolled_back {
        0 => "Events".to_owned(),
        lines => format!("Events, {lines} back"),
    };
    let inside = headed(frame, events, &heading, view);
    panels::draw_events(frame, inside, picture, view);
    frame.render_widget(footer(view), foot);
}

/// The heading of a part of the picture. Returns what is below it.
fn headed(frame: &mut Frame, area: Rect, heading: &str, view: &View) -> Rect {
    let heading = Span::styled(format!("{heading} "), Modifier::BOLD);
    let block = Block::new()
        .borders(Borders::TOP)
        .border_style(view.palette.quiet())
        .title(heading);
    let inside = block.inner(area);
    frame.render_widget(block, area);
    inside
}

fn headline<'a>(picture: &'a Picture, view: &View) -> Line<'a> {
    let state = match &picture.state {
        _ if picture.stopped => " STOPPED ".to_owned(),
        Some(state) => format!(" {} ", state.to_uppercase()),
        None => " STATE NOT TOLD YET ".to_owned(),
    };
    let mut spans = vec![
        Span::styled(state, view.palette.state(picture)),
        Span::raw(format!("  {:.1} s", picture.t_s)),
    ];
    if !picture.time.is_empty() {
        let clock = saying::time_of_day(&picture.time);
        spans.push(Span::raw(format!("  {clock}")));
    }
    if view.ended {
        spans.push(Span::styled(
            "  the stream has ended",
            view.palette.warning(),
        ));
    } else if view.silent > SILENT {
        let silent = format!("  nothing told for {} s", view.silent.as_secs());
        spans.push(Span::styled(silent, view.palette.warning()));
    }
    Line::from(spans)
}

fn footer(view: &View) -> Line<'static> {
    let keys = "q leaves   ↑ ↓ older events   Ctrl-C ends what feeds it, too";
    Line::styled(keys, view.palette.quiet())
}
