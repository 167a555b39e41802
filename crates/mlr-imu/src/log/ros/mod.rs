//! Messages of ROS that hold what an IMU says, in bags of ROS 1 and in MCAP files.
//!
//! Files are read from their beginning to their end, without their index: a recording whose end
//! is missing has none. What no message of the topic needs is passed over, so that neither
//! pictures nor lengths that lie take memory.

mod bag;
mod chunk;
mod imu_message;
mod input;
mod mcap;
mod mcap_records;
mod mcap_stream;
mod rows;
mod topics;

use std::io::Read;

pub(super) use mcap_records::MAGIC as MCAP_MAGIC;
pub use mcap_stream::{McapBegin, McapStream, mcap_library};
pub use rows::ImuRows;

use super::{LogLimits, LogProblem};
use input::Input;
use topics::Topics;

/// Reads the messages of one topic of a bag of ROS 1, format 2.0.
pub(super) fn read_bag(
    bytes: impl Read,
    topic: Option<&str>,
    limits: LogLimits,
) -> Result<ImuRows, LogProblem> {
    let mut topics = Topics::new(topic, limits);
    bag::read(&mut Input::of_file(bytes), &mut topics)?;
    ImuRows::new(topics.finish()?, limits)
}

/// Reads the messages of one topic of an MCAP file.
pub(super) fn read_mcap(
    bytes: impl Read,
    topic: Option<&str>,
    limits: LogLimits,
) -> Result<ImuRows, LogProblem> {
    let mut topics = Topics::new(topic, limits);
    mcap::read(&mut Input::of_file(bytes), &mut topics)?;
    ImuRows::new(topics.finish()?, limits)
}
