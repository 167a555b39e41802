//! What was found out about a robot as one page and as plots.
//!
//! [`Report`] takes results and gives a page in HTML that needs no other file, and its plots one by one
//! ([`Picture`]: SVG, PNG). Answers are read as other programs read them ([`answer`]), so that a page
//! made of a saved answer is the page that is made at once. [`Figure`] draws any curves over one axis.
//!
//! The crate knows no files, no command line, and not how answers are found.

pub mod answer;
mod figure;
mod page;
mod picture;
pub mod plots;
mod report;
mod words;

pub use figure::{Curve, Figure, Ink, Mark, Panel, Rule, thinned};
pub use picture::{Picture, PictureError};
pub use report::{Manifest, Report, ReportError, Walk};
