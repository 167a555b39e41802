//! The plots of a page.

mod course;
mod detector;
mod footfalls;
mod residual;
mod robot_from_above;
mod signals;
mod spectra;

pub use course::course;
pub use detector::{DetectorRun, detector};
pub use footfalls::Footfalls;
pub use residual::residual;
pub use robot_from_above::robot_from_above;
pub use signals::{WalkSignals, signals};
pub use spectra::spectra;

/// Of most plots.
pub(crate) const SIZE: [u32; 2] = [440, 460];
/// Columns that points are thinned to.
pub(crate) const COLUMNS: usize = 450;
