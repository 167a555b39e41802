//! Charts: panels of curves over one horizontal axis.

mod drawing;
mod thinning;

pub use thinning::thinned;

use crate::{Picture, PictureError};

/// Panels of curves over one horizontal axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Name of its file, without an ending: letters, digits and dashes.
    pub name: String,
    /// What it shows, in a few words.
    pub title: String,
    /// What a reader who cannot see it should know.
    pub description: String,
    /// Whether the title is drawn, too.
    pub is_headed: bool,
    /// Quantity and unit of the horizontal axis.
    pub x_label: String,
    /// Places that the horizontal axis shows in any case.
    pub x_shows: Vec<f64>,
    /// From top to bottom.
    pub panels: Vec<Panel>,
    /// Width and height in pixels; text has 13 of them.
    pub size: [u32; 2],
}

/// Curves that share a vertical axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Quantity and unit of the vertical axis.
    pub y_label: String,
    /// In the order in which they are drawn.
    pub curves: Vec<Curve>,
    /// Lines through the whole panel.
    pub rules: Vec<Rule>,
    /// Values that the vertical axis shows in any case.
    pub shows: [f64; 2],
}

/// Points, and how they are drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// In the legend; the same in every panel where it is the same.
    pub name: &'static str,
    /// Its colour.
    pub ink: Ink,
    /// How the points are drawn.
    pub mark: Mark,
    /// In the units of the axes.
    pub points: Vec<(f64, f64)>,
}

/// How points are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// Joined by a line.
    Line,
    /// One dot each.
    Dots,
    /// One dot each, on a line from zero.
    Stems,
}

/// A line through a whole panel, with its name beside it.
#[derive(Debug, Clone, PartialEq)]
pub enum Rule {
    /// Upright, at one place of the horizontal axis.
    At(f64, String, Ink),
    /// Level, at one value of the vertical axis.
    Level(f64, String, Ink),
}

/// What a colour stands for. The colours are those of Okabe and Ito, which colour-blind people tell
/// apart; a page maps them to those of its own for a dark screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ink {
    /// What was measured, or the first of several.
    Measured,
    /// What the model says, or the second of several.
    Simulated,
    /// The third of several; good news.
    Third,
    /// What somebody must not miss.
    Alarm,
    /// What is there for comparison.
    Muted,
    /// Letters and axes.
    Text,
    /// Lines behind everything.
    Grid,
}

impl Ink {
    /// Every ink.
    pub const ALL: [Self; 7] = [
        Self::Measured,
        Self::Simulated,
        Self::Third,
        Self::Alarm,
        Self::Muted,
        Self::Text,
        Self::Grid,
    ];

    /// Red, green and blue on white paper.
    pub fn rgb(self) -> [u8; 3] {
        match self {
            Self::Measured => [0x00, 0x72, 0xb2],
            Self::Simulated => [0xc0, 0x4f, 0x00],
            Self::Third => [0x00, 0x7d, 0x5b],
            Self::Alarm => [0xa8, 0x1e, 0x4a],
            Self::Muted => [0x6b, 0x72, 0x80],
            Self::Text => [0x1f, 0x29, 0x37],
            Self::Grid => [0xe2, 0xe5, 0xea],
        }
    }

    /// As SVG has it.
    pub fn hex(self) -> String {
        let [r, g, b] = self.rgb();
        format!("#{r:02X}{g:02X}{b:02X}")
    }

    /// Name of the page's colour in its place.
    pub fn css_name(self) -> &'static str {
        match self {
            Self::Measured => "measured",
            Self::Simulated => "simulated",
            Self::Third => "third",
            Self::Alarm => "alarm",
            Self::Muted => "muted",
            Self::Text => "text",
            Self::Grid => "grid",
        }
    }
}

impl Panel {
    /// A panel of curves.
    pub fn new(y_label: impl Into<String>, curves: Vec<Curve>) -> Self {
        Self {
            y_label: y_label.into(),
            curves,
            rules: Vec::new(),
            shows: [0.0; 2],
        }
    }
}

impl Curve {
    /// A line through points.
    pub fn line(name: &'static str, ink: Ink, points: Vec<(f64, f64)>) -> Self {
        Self {
            name,
            ink,
            mark: Mark::Line,
            points,
        }
    }

    /// The same with another mark.
    #[must_use]
    pub fn marked(self, mark: Mark) -> Self {
        Self { mark, ..self }
    }
}

impl Figure {
    /// Draws it.
    ///
    /// # Errors
    /// [`PictureError::Chart`] when a coordinate is not finite.
    pub fn draw(&self) -> Result<Picture, PictureError> {
        drawing::draw(self)
    }
}
