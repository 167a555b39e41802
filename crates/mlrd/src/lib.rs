//! The onboard daemon: reads an IMU, watches roll and pitch, notices when the
//! robot is damaged, and identifies the damage.
//!
//! ```text
//! mlrd --port /dev/ttyTHS1
//! ```
//!
//! Three threads: [`source`] reads bytes and survives whatever happens to the
//! port; the main thread decodes, stamps and fuses them ([`sensor`]) and drives
//! the states of the [`monitor`]; a [`worker`] identifies, so that nothing ever
//! delays reading. An [`explainer`] beside them, at the lowest priority, finds out what
//! else is unusual about a damaged walk; what it finds of the sensor is corrected from
//! then on. Events are JSON lines on stdout ([`event`]), messages for
//! people go to stderr. [`Settings`] is everything that can be chosen.

pub mod event;
pub mod explainer;
pub mod line_health;
pub mod monitor;
mod options;
mod priority;
pub mod recorder;
pub mod robot_model;
pub mod saved_state;
pub mod sensor;
mod sensor_correction;
mod service;
mod settings;
pub mod source;
pub mod spike_filter;
pub mod supervisor;
pub mod worker;

pub use options::Options;
pub use service::run;
pub use settings::{FramingName, RecordSettings, Settings};
