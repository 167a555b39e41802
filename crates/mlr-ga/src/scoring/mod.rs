//! How right answers are: identifications against the truth.

mod effects;
mod score;
mod total;
mod truth;

pub use effects::{
    EffectsScore, EffectsTotal, EffectsTruth, KindsVerdict, TrueEffect, TrueTrace, in_words,
    read_effects_truths,
};
pub use score::LogScore;
pub use total::{Confusion, TotalScore};
pub use truth::{Truth, TruthError, read_truths};
