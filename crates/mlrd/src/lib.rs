//! The onboard daemon: reads IMU frames from a serial port, watches roll and
//! pitch, notices when the robot is damaged, and identifies the damage.
//!
//! ```text
//! mlrd --port /dev/ttyTHS1
//! ```
//!
//! Three threads: [`port`] reads bytes and survives whatever happens to the port;
//! the main thread decodes, stamps and fuses them ([`sensor`]) and drives the
//! states of the [`monitor`]; a worker identifies, so that nothing ever delays
//! reading. Events are JSON lines on stdout, messages for people go to stderr.

pub mod event;
pub mod monitor;
mod options;
pub mod port;
pub mod sensor;
mod service;

pub use options::{FramingName, Options};
pub use service::run;
