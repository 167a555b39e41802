//! A gait that walks again, for what is left of a damaged legged robot.
//!
//! [`recover()`] finds which legs swing when, where they stand, and how the body sways over them:
//!
//! 1. A quasi-static screen of every order in which the remaining legs can swing: the centre of mass
//!    stays inside the polygon of the feet that stand, every foot within reach.
//! 2. The most promising plans walk in the simulated model, on several robots that may be the case, and
//!    an evolution strategy improves the best.
//! 3. The way from the nominal stance into the gait: legs that do not walk are folded, and the others
//!    step to their places one after the other.
//!
//! A robot that has walked with such a gait turns by what the model does not know of it.
//! [`WalkedPlan::steered`] makes the same gait turn as far the other way.

mod criterion;
mod diagnosis;
mod first_steps;
mod footholds;
mod gait_plan;
mod nominal_stance;
mod optimise;
mod possible_robot;
mod recovery;
mod rows;
mod screen;
mod settings;
mod statics;
mod steering;
mod support;
mod swing_order;
mod walking;
mod what_is_left;
mod whole_gait;

pub use diagnosis::Diagnosis;
pub use gait_plan::GaitPlan;
pub use possible_robot::PossibleRobot;
pub use recovery::{Outlook, RecoverError, Recovery, Task, recover};
pub use rows::NotFollowed;
pub use settings::RecoverSettings;
pub use steering::{Steered, WalkedPlan};
pub use support::margin_m;
pub use swing_order::{SwingOrder, swing_orders};
pub use walking::Walking;
pub use what_is_left::WhatIsLeft;
