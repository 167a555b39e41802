//! How right answers are: identifications against the truth.

mod score;
mod total;
mod truth;

pub use score::LogScore;
pub use total::{Confusion, TotalScore};
pub use truth::{Truth, TruthError, read_truths};
