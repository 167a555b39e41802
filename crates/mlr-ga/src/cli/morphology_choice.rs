//! A morphology on the command line.

use clap::{Args, ValueEnum};
use mlr_model::{LegLayout, LostLinks, ModelError, Morphology};

/// Which links are still there; all of them, unless it is said otherwise.
#[derive(Debug, Args)]
pub(super) struct MorphologyChoice {
    /// Numbers of the legs that are lost altogether, as in 3,4.
    #[arg(long, value_name = "LEGS", conflicts_with = "morphology")]
    legs_lost: Option<String>,
    /// The existence numbers of all links, as in "111 110 000 111 111 111".
    #[arg(long, value_name = "VECTOR")]
    morphology: Option<String>,
}

impl MorphologyChoice {
    /// The morphology of a robot with this layout.
    pub(super) fn of(&self, layout: &LegLayout) -> Result<Morphology, ModelError> {
        match (&self.morphology, &self.legs_lost) {
            (Some(text), _) => Morphology::parse(text, layout),
            (None, Some(legs)) => Morphology::parse_legs_lost(legs, layout),
            (None, None) => Ok(Morphology::healthy(layout)),
        }
    }
}

/// What became of lost links.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum LossName {
    /// Gone.
    Absent,
    /// Locked clear of the ground.
    Locked,
}

impl From<LossName> for LostLinks {
    fn from(name: LossName) -> Self {
        match name {
            LossName::Absent => Self::Absent,
            LossName::Locked => Self::Locked,
        }
    }
}
