//! The comparison that decides: measured and simulated walk, forgiven what sensor
//! and model cannot know.
//!
//! The paper's F sums the absolute errors of all three angles, sample by sample.
//! It punishes a delay of the servos more than a lost link, and trusts yaw, which
//! depends on friction, as much as roll. Here, instead,
//!
//! - what is compared is the spectrum below the cutoff of Algorithm 2 ([`AlignedMeasurement`]),
//!   in which the harmonics of the gait count in full and what lies between them counts less
//!   ([`SpectralSettings`]);
//! - the mean and the linear trend of each angle do not count: a sensor mounted at
//!   a tilt, a slope, a drift of yaw;
//! - delay and gait clock are fitted for every candidate ([`Alignment`]);
//! - each axis is judged on its own scale ([`Misfit`]), so that an axis on which
//!   model and robot agree badly does not drown the others.

mod aligned;
mod comparable_walk;
mod misfit;
mod spectral_form;

pub use aligned::{AlignedMeasurement, Alignment};
pub use comparable_walk::ComparableWalk;
pub use misfit::{LikelihoodSettings, Misfit};
pub use spectral_form::SpectralSettings;
