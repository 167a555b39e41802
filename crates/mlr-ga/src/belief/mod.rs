//! How sure the answer is: priors over damage, what a log makes of them, and whether any
//! morphology explains it at all.

mod plausibility;
mod posterior;
mod prior;

pub use plausibility::{ErrorModel, MeanErrorModel, PlausibilitySettings};
pub use posterior::{Belief, Posterior};
pub use prior::DamagePrior;
