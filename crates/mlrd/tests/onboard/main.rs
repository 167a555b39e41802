//! The daemon as a process, with real pseudo-terminals and pipes. One program, because its tests
//! mostly wait and the longest of them keeps one core busy: the others run beside it.
//!
//! A process that is started here inherits what is open, the ends of other tests' pseudo-terminals
//! among it. Tests that unplug a line are a program of their own, or run alone (`real_time`).
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod bad_sensor;
mod calibrated_robot;
mod check;
#[path = "../daemon/mod.rs"]
mod daemon;
mod explanation;
mod load;
mod real_time;
mod stdin;
mod unread_output;
