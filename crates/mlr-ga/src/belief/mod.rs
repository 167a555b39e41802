//! How sure the answer is: priors over damage, and what a log makes of them.

mod posterior;
mod prior;

pub use posterior::Posterior;
pub use prior::DamagePrior;
