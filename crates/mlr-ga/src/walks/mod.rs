//! Where the walks of candidates come from.

mod simulated;
mod variations;

pub use simulated::SimulatedWalks;
pub use variations::usual_variations;

use std::ops::ControlFlow;

use mlr_model::{LostLinks, Morphology};

use crate::comparison::ComparableWalk;

/// The model that a candidate is simulated with, besides its morphology.
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
    /// To its end.
    Whole(ComparableWalk),
    /// It was abandoned.
    Stopped,
    /// The simulation diverged.
    Diverged,
    /// The source has no such walk.
    Unknown,
}

/// Is called at checkpoints with the walk so far, and decides whether to go on.
pub type Look<'a> = dyn FnMut(&ComparableWalk) -> ControlFlow<()> + 'a;

/// A source of simulated walks.
pub trait WalkSource: Sync {
    /// The walk of a candidate; always the same for the same candidate and case.
    /// `look` may be called at checkpoints.
    fn walk(&self, candidate: &Morphology, case: Case, look: &mut Look<'_>) -> Walked;
}
