use ratatui::style::{Color, Modifier, Style};

use crate::{event::Level, top::picture::Picture};

/// Styles: the colours of the terminal's own theme, or none. Nothing is told by colour alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Palette {
    /// Colours.
    Colored,
    /// Bold and reversed text at most.
    Plain,
}

impl Palette {
    /// Plain where `NO_COLOR` has a value (<https://no-color.org>).
    pub fn of_no_color(no_color: Option<&std::ffi::OsStr>) -> Self {
        match no_color.is_some_and(|value| !value.is_empty()) {
            true => Self::Plain,
            false => Self::Colored,
        }
    }

    fn colored(self, color: Color) -> Style {
        match self {
            Self::Colored => Style::new().fg(color),
            Self::Plain => Style::new(),
        }
    }

    pub(super) fn quiet(self) -> Style {
        match self {
            Self::Colored => Style::new().fg(Color::DarkGray),
            Self::Plain => Style::new(),
        }
    }

    pub(super) fn warning(self) -> Style {
        self.of_level(Level::Warn)
    }

    pub(super) fn of_level(self, level: Level) -> Style {
        match level {
            Level::Ok => Style::new(),
            Level::Warn => self.colored(Color::Yellow).add_modifier(Modifier::BOLD),
            Level::Error => self.colored(Color::Red).add_modifier(Modifier::BOLD),
            Level::Stale => self.colored(Color::Magenta).add_modifier(Modifier::BOLD),
        }
    }

    /// Of a leg, by the probability that it is damaged.
    pub(super) fn damage(self, probability: Option<f64>) -> Style {
        match probability {
            None => Style::new(),
            Some(p) if p < 0.1 => self.colored(Color::Green),
            Some(p) if p < 0.5 => self.colored(Color::Yellow),
            Some(_) => self.colored(Color::Red).add_modifier(Modifier::BOLD),
        }
    }

    pub(super) fn fluctuation(self, is_above: bool) -> Style {
        match is_above {
            true => self.colored(Color::Red),
            false => self.colored(Color::Green),
        }
    }

    pub(super) fn state(self, picture: &Picture) -> Style {
        let color = match picture.state.as_deref() {
            _ if picture.stopped => Color::Magenta,
            Some("standing" | "walking") => Color::Green,
            Some("flagged" | "identifying") => Color::Yellow,
            Some("identified") => Color::Red,
            _ => Color::Reset,
        };
        self.colored(color).add_modifier(Modifier::REVERSED)
    }
}
