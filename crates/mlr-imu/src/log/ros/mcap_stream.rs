use std::{
    collections::BTreeMap,
    io::{self, Read, Seek, Write},
};

use mcap::{
    McapError, WriteOptions, Writer,
    records::{MessageHeader, Record},
};
use mlr_filter::Axes;
use nalgebra::UnitQuaternion;

use super::{
    imu_message::{ImuMessage, Stamp},
    mcap::AXES,
};
use crate::ImuSample;

/// What an MCAP file says of each type that it holds, as ROS 2 does.
const IMU_DEFINITION: &str = include_str!("sensor_msgs_Imu.msg");

/// A log that grows message by message, as MCAP with `sensor_msgs/msg/Imu` of ROS 2, which
/// Foxglove, Rerun and PlotJuggler open.
pub struct McapStream<W: Write + Seek> {
    file: Writer<W>,
    channel: u16,
    sequence: u32,
    frame: &'static str,
    /// What the log's time zero is.
    begin_ns: i64,
    /// Bytes of messages so far.
    bytes: u64,
}

/// Bytes of a record around a message.
const RECORD_BYTES: u64 = 31;
/// The longest beginning of a file that its writer's name is looked for in.
const MAX_HEADER_BYTES: u64 = 1000;

/// What wrote an MCAP file, by the file's beginning; `None` if it is none.
pub fn mcap_library(begin: impl Read) -> Option<String> {
    let mut bytes = Vec::new();
    begin.take(MAX_HEADER_BYTES).read_to_end(&mut bytes).ok()?;
    let (kind, rest) = bytes.strip_prefix(mcap::MAGIC)?.split_first()?;
    let (length, rest) = rest.split_first_chunk()?;
    let header = rest.get(..usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
    match mcap::parse_record(*kind, header).ok()? {
        Record::Header(header) => Some(header.library),
        _ => None,
    }
}

/// What an MCAP file begins with.
#[derive(Debug, Clone, Copy)]
pub struct McapBegin<'a> {
    /// What writes it.
    pub library: &'a str,
    /// What the log's time zero is, in nanoseconds since 1970.
    pub begin_ns: i64,
    /// Whether the mounting of the sensor has been applied to its messages.
    pub in_body_axes: bool,
    /// Whether its messages have orientations.
    pub has_orientations: bool,
    /// In chunks it gets an index at its end; without, every message is whole in the file as soon
    /// as it was handed on, whatever happens then.
    pub chunked: bool,
}

impl<W: Write + Seek> McapStream<W> {
    /// A log without messages.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn new(file: W, begin: &McapBegin<'_>) -> io::Result<Self> {
        let options = WriteOptions::new()
            .compression(None)
            .profile("ros2")
            .library(begin.library)
            .use_chunks(begin.chunked);
        let mut file = options.create(file).map_err(as_io)?;
        let definition = IMU_DEFINITION.as_bytes();
        let schema = file.add_schema("sensor_msgs/msg/Imu", "ros2msg", definition);
        let mut metadata = BTreeMap::new();
        let frame = match begin.in_body_axes {
            true => {
                let (key, value) = AXES;
                metadata.insert(key.into(), value.into());
                "base_link"
            }
            false => "imu_link",
        };
        // The names of REP 145.
        let topic = match begin.has_orientations {
            true => "/imu/data",
            false => "/imu/data_raw",
        };
        let channel = file.add_channel(schema.map_err(as_io)?, topic, "cdr", &metadata);
        Ok(Self {
            channel: channel.map_err(as_io)?,
            file,
            sequence: 0,
            frame,
            begin_ns: begin.begin_ns,
            bytes: 0,
        })
    }

    /// Adds a message.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(
        &mut self,
        time_s: f64,
        angles_rad: Option<&Axes<f64>>,
        sample: &ImuSample,
    ) -> io::Result<()> {
        let time_ns = self
            .begin_ns
            .saturating_add((time_s * 1e9).round() as i64)
            .max(0);
        let message = ImuMessage {
            stamp: Stamp::default(),
            orientation: angles_rad.map(|angles| {
                let turned =
                    UnitQuaternion::from_euler_angles(angles.roll, angles.pitch, angles.yaw);
                [turned.w, turned.i, turned.j, turned.k]
            }),
            rate_radps: sample.angular_rate_radps.map(Into::into),
            acceleration_mps2: sample.acceleration_mps2.map(Into::into),
        };
        let header = MessageHeader {
            channel_id: self.channel,
            sequence: self.sequence,
            log_time: time_ns as u64,
            publish_time: time_ns as u64,
        };
        self.sequence = self.sequence.wrapping_add(1);
        let bytes = ImuMessage::to_cdr(time_ns, self.frame, &message);
        self.bytes += RECORD_BYTES + bytes.len() as u64;
        self.file
            .write_to_known_channel(&header, &bytes)
            .map_err(as_io)
    }

    /// Bytes of messages written so far, with what stands around them.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Hands on what is still held back.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn flush(&mut self) -> io::Result<()> {
        self.file.flush().map_err(as_io)
    }

    /// Writes the end of the file.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(&mut self) -> io::Result<()> {
        self.file.finish().map_err(as_io)?;
        Ok(())
    }
}

fn as_io(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}
