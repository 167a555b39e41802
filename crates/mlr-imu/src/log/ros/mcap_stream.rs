use std::io::{self, Read, Write};

use flate2::Crc;
use mlr_filter::Axes;
use nalgebra::UnitQuaternion;

use super::{
    imu_message::{ImuMessage, Stamp},
    mcap::AXES,
    mcap_records::{MAGIC, NewRecord, library, op},
};
use crate::ImuSample;

/// What an MCAP file says of the type, as ROS 2 does.
const IMU_DEFINITION: &str = include_str!("sensor_msgs_Imu.msg");
/// The only schema, and the only channel.
const SCHEMA: u16 = 1;
const CHANNEL: u16 = 1;
/// A chunk is closed when it has reached this size.
const CHUNK_BYTES: usize = 1 << 20;
/// The longest beginning of a file that its writer's name is looked for in.
const MAX_HEADER_BYTES: u64 = 1000;

/// A log that grows message by message, as MCAP with `sensor_msgs/msg/Imu` of ROS 2, which
/// Foxglove, Rerun and PlotJuggler open.
///
/// A file that was not finished has no index, and all else of what was handed on.
pub struct McapStream<W> {
    file: W,
    /// Bytes written to the file.
    written: u64,
    declarations: Vec<u8>,
    frame: &'static str,
    begin_ns: i64,
    messages: u32,
    /// Of the first and the last message in time.
    span_ns: Option<(u64, u64)>,
    /// Where messages are gathered, if they are.
    chunk: Option<Chunk>,
    chunk_indexes: Vec<u8>,
    chunks: u32,
    is_finished: bool,
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

/// Messages on their way to the file.
#[derive(Debug, Default)]
struct Chunk {
    records: Vec<u8>,
    /// Time and place of each.
    index: Vec<u8>,
    span_ns: Option<(u64, u64)>,
}

/// What wrote an MCAP file, by the file's beginning; `None` if it is none.
pub fn mcap_library(begin: impl Read) -> Option<String> {
    let mut bytes = Vec::new();
    begin.take(MAX_HEADER_BYTES).read_to_end(&mut bytes).ok()?;
    let (kind, rest) = bytes.strip_prefix(MAGIC)?.split_first()?;
    let (length, rest) = rest.split_first_chunk()?;
    let header = rest.get(..usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
    let library = library(header).filter(|_| *kind == op::HEADER);
    library.map(String::from)
}

impl<W: Write> McapStream<W> {
    /// A log without messages.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn new(file: W, begin: &McapBegin<'_>) -> io::Result<Self> {
        let (key, value) = AXES;
        let (frame, metadata) = match begin.in_body_axes {
            true => ("base_link", NewRecord::default().text(key).text(value)),
            false => ("imu_link", NewRecord::default()),
        };
        // The names of REP 145.
        let topic = match begin.has_orientations {
            true => "/imu/data",
            false => "/imu/data_raw",
        };
        let schema = NewRecord::default()
            .u16(SCHEMA)
            .text("sensor_msgs/msg/Imu")
            .text("ros2msg")
            .text(IMU_DEFINITION);
        let channel = NewRecord::default()
            .u16(CHANNEL)
            .u16(SCHEMA)
            .text(topic)
            .text("cdr")
            .bytes(&metadata.content());
        let declarations = [schema.of_kind(op::SCHEMA), channel.of_kind(op::CHANNEL)].concat();
        let mut stream = Self {
            file,
            written: 0,
            declarations: declarations.clone(),
            frame,
            begin_ns: begin.begin_ns,
            messages: 0,
            span_ns: None,
            chunk: begin.chunked.then(Chunk::default),
            chunk_indexes: Vec::new(),
            chunks: 0,
            is_finished: false,
        };
        let header = NewRecord::default().text("ros2").text(begin.library);
        stream.add(MAGIC)?;
        stream.add(&header.of_kind(op::HEADER))?;
        stream.add(&declarations)?;
        Ok(stream)
    }

    /// Adds a message, with what is known of orientation and sample.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(
        &mut self,
        time_s: f64,
        angles_rad: Option<&Axes<f64>>,
        sample: &ImuSample,
    ) -> io::Result<()> {
        let since_zero_ns = (time_s * 1e9).round() as i64;
        let time_ns = self.begin_ns.saturating_add(since_zero_ns).max(0);
        let message = ImuMessage {
            stamp: Stamp::of_ns(time_ns),
            orientation: angles_rad.map(|Axes { roll, pitch, yaw }| {
                let turned = UnitQuaternion::from_euler_angles(*roll, *pitch, *yaw);
                [turned.w, turned.i, turned.j, turned.k]
            }),
            rate_radps: sample.angular_rate_radps.map(Into::into),
            acceleration_mps2: sample.acceleration_mps2.map(Into::into),
        };
        let time_ns = time_ns as u64;
        let record = NewRecord::default()
            .u16(CHANNEL)
            .u32(self.messages)
            // Of recording and of publication.
            .u64(time_ns)
            .u64(time_ns)
            .raw(&message.to_cdr(self.frame))
            .of_kind(op::MESSAGE);
        self.messages = self.messages.wrapping_add(1);
        self.span_ns = Some(widened(self.span_ns, time_ns));
        let Some(chunk) = &mut self.chunk else {
            return self.add(&record);
        };
        chunk.index.extend(time_ns.to_le_bytes());
        chunk
            .index
            .extend((chunk.records.len() as u64).to_le_bytes());
        chunk.records.extend(record);
        chunk.span_ns = Some(widened(chunk.span_ns, time_ns));
        if chunk.records.len() >= CHUNK_BYTES {
            self.write_chunk()?;
        }
        Ok(())
    }

    /// Bytes written to the file so far.
    pub fn bytes(&self) -> u64 {
        self.written
    }

    /// Hands on what is still held back, other than the messages of a chunk.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }

    /// Writes the end of the file: types, topics, numbers and places of messages. Nothing more can
    /// be added; finishing again does nothing.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(&mut self) -> io::Result<()> {
        if std::mem::replace(&mut self.is_finished, true) {
            return Ok(());
        }
        self.write_chunk()?;
        // Check sums of zero are none.
        self.add(&NewRecord::default().u32(0).of_kind(op::DATA_END))?;
        let summary = self.written;
        let (begin_ns, end_ns) = self.span_ns.unwrap_or_default();
        let messages = u64::from(self.messages);
        let statistics = NewRecord::default()
            .u64(messages)
            // Schemas, channels, attachments, metadata, chunks.
            .u16(1)
            .u32(1)
            .u32(0)
            .u32(0)
            .u32(self.chunks)
            .u64(begin_ns)
            .u64(end_ns)
            .bytes(&NewRecord::default().u16(CHANNEL).u64(messages).content());
        let footer = NewRecord::default().u64(summary).u64(0).u32(0);
        let end = [
            std::mem::take(&mut self.declarations),
            statistics.of_kind(op::STATISTICS),
            std::mem::take(&mut self.chunk_indexes),
            footer.of_kind(op::FOOTER),
            MAGIC.to_vec(),
        ];
        self.add(&end.concat())?;
        self.flush()
    }

    fn write_chunk(&mut self) -> io::Result<()> {
        let Some(chunk) = self.chunk.as_mut().filter(|chunk| chunk.span_ns.is_some()) else {
            return Ok(());
        };
        let Chunk {
            records,
            index,
            span_ns,
        } = std::mem::take(chunk);
        let (begin_ns, end_ns) = span_ns.unwrap_or_default();
        let mut crc = Crc::new();
        crc.update(&records);
        let bytes = records.len() as u64;
        let chunk = NewRecord::default()
            .u64(begin_ns)
            .u64(end_ns)
            .u64(bytes)
            .u32(crc.sum())
            // No compression.
            .text("")
            .u64(bytes)
            .raw(&records)
            .of_kind(op::CHUNK);
        let index = NewRecord::default().u16(CHANNEL).bytes(&index);
        let index = index.of_kind(op::MESSAGE_INDEX);
        let (begin, chunk_bytes) = (self.written, chunk.len() as u64);
        let offsets = NewRecord::default().u16(CHANNEL).u64(begin + chunk_bytes);
        let chunk_index = NewRecord::default()
            .u64(begin_ns)
            .u64(end_ns)
            .u64(begin)
            .u64(chunk_bytes)
            .bytes(&offsets.content())
            .u64(index.len() as u64)
            .text("")
            .u64(bytes)
            .u64(bytes);
        self.chunk_indexes
            .extend(chunk_index.of_kind(op::CHUNK_INDEX));
        self.chunks += 1;
        self.add(&chunk)?;
        self.add(&index)
    }

    fn add(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.file.write_all(bytes)?;
        self.written += bytes.len() as u64;
        Ok(())
    }
}

fn widened(span_ns: Option<(u64, u64)>, time_ns: u64) -> (u64, u64) {
    let (begin_ns, end_ns) = span_ns.unwrap_or((time_ns, time_ns));
    (begin_ns.min(time_ns), end_ns.max(time_ns))
}
