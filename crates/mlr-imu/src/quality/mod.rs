//! What samples and logs say about themselves, before anybody asks what the robot did.

mod fault;
mod held_values;
mod sample_health;

pub use fault::{FaultKind, SampleFault};
pub use sample_health::SampleHealth;
