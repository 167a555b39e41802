//! How right answers are: identifications against the truth.

mod effects;
mod effects_total;
mod effects_truth;
mod kind_calibration;
mod kinds;
mod score;
mod total;
mod truth;
mod visibility;

pub use effects::{EffectsScore, Errors, FoundEffect, PlaceScore, UnansweredLog, Verdict};
pub use effects_total::{
    ClassTotal, EffectsTotal, Elapsed, KindsTotal, LegsTotal, PlacesTotal, Share,
};
pub use effects_truth::{
    EffectsTruth, LogClass, Origin, TrueEffect, in_words, read_effects_truths,
};
pub use kind_calibration::KindCalibration;
pub use kinds::{KindsScore, LOG_SCORE_FLOOR, SURE, Statement};
pub use score::LogScore;
pub use total::{Confusion, TotalScore};
pub use truth::{Truth, TruthError, read_truths};
pub use visibility::{Spread, TrueTrace, Visibility};
