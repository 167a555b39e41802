//! Where the walks of candidates come from.

mod simulated;
mod variations;

pub use simulated::SimulatedWalks;
pub use variations::usual_variations;

use std::ops::ControlFlow;

use mlr_model::{LostLinks, Morphology};

use crate::comparison::ComparableWalk;

/// What a candidate walks like, besides its morphology.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Case {
    /// What its lost links have become.
    pub lost_links: LostLinks,
    /// Which variation of the model, counted from the nominal one, 0.
    pub variation: usize,
}

/// How a walk ended.
#[derive(Debug, Clone, PartialEq)]
pub enum Walked {
    /// As it should.
    Whole(ComparableWalk),
    /// It was not worth going on.
    Stopped,
    /// The simulation diverged.
    Diverged,
    /// There is no such walk to be had.
    Unknown,
}

/// Looks at the walk so far and says whether it is worth going on.
pub type Look<'a> = dyn FnMut(&ComparableWalk) -> ControlFlow<()> + 'a;

/// Something that knows how candidates walk.
pub trait WalkSource: Sync {
    /// The walk of a candidate. The same candidate and case always walk the same.
    /// `look` may be shown parts of the walk.
    fn walk(&self, candidate: &Morphology, case: Case, look: &mut Look<'_>) -> Walked;
}
