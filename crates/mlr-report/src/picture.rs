//! A picture as SVG, and from that as PNG.

use std::sync::{Arc, LazyLock};

use askama::Template;
use resvg::{
    tiny_skia::{Color, Pixmap, Transform},
    usvg::{Options, Tree, fontdb::Database},
};
use thiserror::Error;

/// A picture as SVG, in the colours of white paper.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    name: String,
    title: String,
    svg: String,
}

/// Why there is no picture.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PictureError {
    /// A chart cannot be drawn.
    #[error("{title}: {reason}")]
    Chart {
        /// What it would have shown.
        title: String,
        /// Why it cannot.
        reason: String,
    },
    /// A template cannot be filled.
    #[error(transparent)]
    Template(#[from] askama::Error),
    /// An SVG cannot be read again to make a PNG of it.
    #[error(transparent)]
    Svg(#[from] resvg::usvg::Error),
    /// A PNG of this size cannot be made.
    #[error("a picture of {width} by {height} pixels cannot be made, expected 1 to {most} each")]
    Size {
        /// Width wanted.
        width: f32,
        /// Height wanted.
        height: f32,
        /// The most that is made.
        most: f32,
    },
    /// A PNG cannot be written.
    #[error("{0}")]
    Png(String),
}

/// What holds the lines of a picture together.
#[derive(Template)]
#[template(path = "picture.svg", escape = "html")]
struct Frame<'a> {
    name: &'a str,
    title: &'a str,
    description: &'a str,
    size: [u32; 2],
    view: [u32; 2],
    content: &'a str,
}

/// The largest PNG, in pixels each way.
const MOST_PIXELS: f32 = 20_000.0;

impl Picture {
    /// A picture of `size` pixels whose `content`, SVG without its outermost element, has
    /// coordinates up to `view`.
    pub(crate) fn new(
        name: &str,
        title: &str,
        description: &str,
        size: [u32; 2],
        view: [u32; 2],
        content: &str,
    ) -> Self {
        let frame = Frame {
            name,
            title,
            description,
            size,
            view,
            content,
        };
        Self {
            name: name.into(),
            title: title.into(),
            svg: frame
                .render()
                .expect("texts and numbers can always be written"),
        }
    }

    /// Name of its file, without an ending.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What it shows, in a few words.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// As SVG, transparent where nothing is drawn.
    pub fn svg(&self) -> &str {
        &self.svg
    }

    /// As PNG on white, so many times as large as the SVG. Its letters are DejaVu Sans on every
    /// computer.
    ///
    /// # Errors
    /// [`PictureError::Size`] when it would be too large.
    pub fn png(&self, scale: f32) -> Result<Vec<u8>, PictureError> {
        static FONTS: LazyLock<Arc<Database>> = LazyLock::new(|| {
            let mut fonts = Database::new();
            fonts.load_font_data(dejavu::sans::regular().to_vec());
            fonts.set_sans_serif_family("DejaVu Sans");
            Arc::new(fonts)
        });
        let options = Options {
            font_family: "DejaVu Sans".into(),
            fontdb: Arc::clone(&FONTS),
            ..Options::default()
        };
        let tree = Tree::from_str(&self.svg, &options)?;
        let [width, height] = [tree.size().width(), tree.size().height()].map(|w| w * scale);
        let too_large = || PictureError::Size {
            width,
            height,
            most: MOST_PIXELS,
        };
        let fits = |pixels: f32| (1.0..=MOST_PIXELS).contains(&pixels);
        if !(fits(width) && fits(height)) {
            return Err(too_large());
        }
        let mut pixels = Pixmap::new(width as u32, height as u32).ok_or_else(too_large)?;
        pixels.fill(Color::WHITE);
        let scaled = Transform::from_scale(scale, scale);
        resvg::render(&tree, scaled, &mut pixels.as_mut());
        pixels
            .encode_png()
            .map_err(|error| PictureError::Png(error.to_string()))
    }
}
