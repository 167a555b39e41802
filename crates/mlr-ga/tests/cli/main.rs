//! What a user of `mlr-ga` gets: the program as it is run, one file for each topic. One program for all, so that
//! long tests run beside short ones.
#![cfg(feature = "cli")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod atlas;
mod bad_input;
mod calibrate;
mod described;
mod evaluate_effects;
mod exchange;
mod explain_sensor;
mod explain_servo;
mod foreign_logs;
mod hostile_files;
mod in_browser;
mod interrupted;
mod joint_trajectories;
mod paper_method;
mod probe;
mod program;
mod recover;
mod report;
mod robot_check;
mod ros_files;
mod round_trip;
mod schema_check;
mod several_logs;
mod shards;
