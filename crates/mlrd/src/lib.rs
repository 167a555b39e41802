//! The onboard daemon: reads an IMU, watches roll and pitch, notices when the
//! robot is damaged, and identifies the damage.
//!
//! ```text
//! mlrd --port /dev/ttyTHS1
//! ```
//!
//! [`source`] reads bytes on a thread of its own and survives whatever happens to the
//! port; the main thread decodes, stamps, checks and fuses them ([`sensor`], [`attitude`]) and drives
//! the states of the [`monitor`]; a [`worker`] identifies, so that nothing ever
//! delays reading. In the [`background`], at the lowest priority, an [`explainer`] finds out what
//! else is unusual about a damaged walk, and what it finds of the sensor is corrected from
//! then on; healthy walks are learned from ([`learning`]). Events are JSON lines on stdout ([`event`]), messages for people go to
//! stderr, both from threads of their own ([`output`]): nothing waits for a reader.
//! While the sensor has a fault ([`sensor_fault`]) nothing is concluded about the robot.
//! `mlrd check` tells beforehand what is missing for all of that (`check`).
//! `mlrd top` shows events on a terminal (`top`, a feature that is on by default).
//! [`Settings`] is everything that can be chosen.

pub mod attitude;
pub mod background;
mod check;
mod command_line;
pub mod event;
pub mod explainer;
pub mod learning;
pub mod line_health;
pub mod monitor;
pub mod mounting_check;
mod options;
pub mod output;
mod priority;
pub mod recorder;
pub mod recovery_offer;
pub mod robot_model;
pub mod sample_rate;
pub mod saved_state;
pub mod sensor;
mod sensor_correction;
pub mod sensor_fault;
mod service;
mod settings;
pub mod source;
pub mod spike_filter;
pub mod stopped_clock;
pub mod supervisor;
#[cfg(feature = "top")]
pub mod top;
pub mod worker;

pub use command_line::CommandLine;
pub use options::Options;
pub use service::run;
pub use settings::{FramingName, RecordFormat, RecordSettings, Settings};
