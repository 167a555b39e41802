//! What samples and logs say about themselves, before anybody asks what the robot did.
//!
//! [`SampleHealth`] watches the samples of a sensor one by one; [`LogQuality`] examines a
//! whole log. Neither knows the robot: only what a sensor can measure and a body can do.

mod fault;
mod finding;
mod gravity;
mod held_values;
mod interleaving;
mod log_quality;
mod rows;
mod sample_health;
mod saturation;
mod tipping;
mod units;

pub use fault::{FaultKind, SampleFault};
pub use finding::{Finding, FindingKind, Severity};
pub use log_quality::LogQuality;
pub use sample_health::SampleHealth;
