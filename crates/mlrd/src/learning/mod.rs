//! What the daemon learns of its own robot while nothing is wrong with it.
//!
//! ```text
//! healthy stretches ─► variety: which next ─► round: checked, fitted, compared on another stretch
//!  (of the monitor)         budget: when                     │
//!                                                            ▼
//!                 robot of identifications  ◄── calibrations: this, the one before, the reference
//!                    and explanations                        │
//!                                                            └─► wear: what has drifted
//! ```

mod budget;
mod calibrations;
mod forgetting;
mod round;
mod saved;
mod settings;
mod variety;
mod wear;

pub use calibrations::{Calibrations, KnownCalibration, LearnedRobot};
pub use round::{LearnError, Lesson, Outcome, Round};
pub use saved::{CalibrationMismatch, SavedCalibration, SavedCalibrations};
pub use settings::LearningSettings;
pub use variety::Variety;
pub use wear::{Wear, wear};

pub(crate) use budget::ProcessorBudget;
