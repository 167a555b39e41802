//! Probabilities of the answer: the prior over damage, the posterior given a log, and whether
//! any morphology explains it.

mod plausibility;
mod posterior;
mod prior;

pub use plausibility::{ErrorModel, MeanErrorModel, PlausibilitySettings};
pub use posterior::{Belief, Posterior};
pub use prior::DamagePrior;
