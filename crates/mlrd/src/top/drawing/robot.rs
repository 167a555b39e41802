use ratatui::{
    Frame,
    layout::{Alignment, Rect},
    style::Style,
    text::{Line, Span},
    widgets::Paragraph,
};

use super::Palette;
use crate::top::{picture::Picture, saying};

/// The two lines of one leg: its number, name and links; the probability that it is damaged.
struct DrawnLeg {
    title: String,
    /// From the foot to the body.
    links: String,
    probability: String,
    style: Style,
}

/// Columns of the body, its edges included.
const BODY: usize = 7;

/// Legs of the left side and of the right, from the front to the rear.
fn sides(picture: &Picture) -> [Vec<usize>; 2] {
    let hip_m = |leg: &usize| picture.robot.legs[*leg].hip_m;
    [true, false].map(|is_left| {
        let legs = 0..picture.robot.legs.len();
        let mut side: Vec<usize> = legs
            .filter(|leg| (hip_m(leg)[1] > 0.0) == is_left)
            .collect();
        side.sort_by(|a, b| hip_m(b)[0].total_cmp(&hip_m(a)[0]));
        side
    })
}

/// How many lines the robot takes.
pub(super) fn lines(picture: &Picture) -> u16 {
    let pairs = sides(picture).map(|side| side.len()).into_iter().max();
    2 * pairs.unwrap_or(0) as u16
}

/// The robot from above, forward up. Lost links are dotted.
pub(super) fn draw(frame: &mut Frame, area: Rect, picture: &Picture, palette: Palette) {
    let [left, right] = sides(picture);
    let mut lines = Vec::new();
    for pair in 0..left.len().max(right.len()) {
        let at = |side: &[usize]| side.get(pair).map(|&leg| drawn(picture, leg, palette));
        lines.extend(pair_lines(at(&left), at(&right), pair == 0));
    }
    frame.render_widget(Paragraph::new(lines).alignment(Alignment::Center), area);
}

fn drawn(picture: &Picture, leg: usize, palette: Palette) -> DrawnLeg {
    let (described, condition) = (&picture.robot.legs[leg], picture.legs[leg]);
    let (links, lost) = (described.links, condition.lost_links);
    let probability = match condition.damage_probability {
        Some(probability) => saying::percent(probability),
        // Known from before, or not yet.
        None if lost > 0 => "damaged".into(),
        None => "–".into(),
    };
    DrawnLeg {
        title: format!("{} {}", leg + 1, described.name).trim_end().into(),
        links: "╌".repeat(lost) + &"━".repeat(links.saturating_sub(lost)),
        probability,
        style: palette.damage(match condition.damage_probability {
            None if lost > 0 => Some(1.0),
            probability => probability,
        }),
    }
}

fn pair_lines<'a>(
    left: Option<DrawnLeg>,
    right: Option<DrawnLeg>,
    is_first: bool,
) -> [Line<'a>; 2] {
    let width = |leg: &Option<DrawnLeg>| {
        let leg = leg.as_ref();
        leg.map_or(0, |leg| {
            leg.title.chars().count() + 1 + leg.links.chars().count()
        })
    };
    // Both sides are as wide, so that the body stands in the middle.
    let side = width(&left).max(width(&right));
    let links = |leg: &Option<DrawnLeg>| leg.as_ref().map_or(0, |leg| leg.links.chars().count());
    let joint = |leg: &Option<DrawnLeg>, joined, not| if leg.is_some() { joined } else { not };
    let middle = format!(
        "{}{:^inside$}{}",
        joint(&left, '┤', '│'),
        if is_first { "▲" } else { "" },
        joint(&right, '├', '│'),
        inside = BODY - 2
    );
    let body = format!("│{}│", " ".repeat(BODY - 2));
    let style = |leg: &Option<DrawnLeg>| leg.as_ref().map_or(Style::new(), |leg| leg.style);
    let (left_links, right_links) = (links(&left), links(&right));
    let (left_style, right_style) = (style(&left), style(&right));
    let [left_title, left_probability] = left.map_or([String::new(), String::new()], |leg| {
        [format!("{} {}", leg.title, leg.links), leg.probability]
    });
    let [right_title, right_probability] = right.map_or([String::new(), String::new()], |leg| {
        let links: String = leg.links.chars().rev().collect();
        [format!("{links} {}", leg.title), leg.probability]
    });
    let (left_room, right_room) = (side.saturating_sub(left_links + 1), right_links + 1);
    [
        Line::from(vec![
            Span::styled(format!("{left_title:>side$}"), left_style),
            Span::raw(middle),
            Span::styled(format!("{right_title:<side$}"), right_style),
        ]),
        Line::from(vec![
            Span::styled(format!("{left_probability:>left_room$}"), left_style),
            Span::raw(" ".repeat(side - left_room) + &body + &" ".repeat(right_room)),
            Span::styled(
                format!(
                    "{right_probability:<room$}",
                    room = side.saturating_sub(right_room)
                ),
                right_style,
            ),
        ]),
    ]
}
