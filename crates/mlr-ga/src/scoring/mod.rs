//! How right answers are: identifications against the truth.

mod effects;
mod effects_total;
mod score;
mod total;
mod truth;
mod visibility;

pub use effects::{
    EffectsScore, EffectsTruth, KindsVerdict, TrueEffect, in_words, read_effects_truths,
};
pub use effects_total::EffectsTotal;
pub use score::LogScore;
pub use total::{Confusion, TotalScore};
pub use truth::{Truth, TruthError, read_truths};
pub use visibility::{Spread, TrueTrace, Visibility};
