//! Bags of ROS 1, format 2.0 (<https://wiki.ros.org/Bags/Format/2.0>).
//!
//! The one crate for them, `rosbag`, maps files into memory, which is undefined behaviour when
//! somebody changes them, has C libraries decompress them, and reads neither pipes nor
//! recordings without an index. The format is small enough to read here.

use std::io::Read;

use super::{
    super::LogProblem,
    chunk::{Chunk, Compression},
    imu_message::{MAX_MESSAGE_BYTES, Stamp},
    input::Input,
    topics::{Kind, Topics},
};

/// The first line.
const MAGIC_BYTES: u64 = 13;
/// The longest header of a record, and of a connection, which has the definition of its type.
const MAX_HEADER_BYTES: u64 = 100_000;
const MAX_CONNECTION_BYTES: u64 = 10_000_000;

/// What a record is, as its header's `op` says.
mod op {
    pub(super) const MESSAGE: u8 = 0x02;
    pub(super) const BAG: u8 = 0x03;
    pub(super) const INDEX: u8 = 0x04;
    pub(super) const CHUNK: u8 = 0x05;
    pub(super) const CHUNK_INFO: u8 = 0x06;
    pub(super) const CONNECTION: u8 = 0x07;
}

/// Reads a bag from its beginning.
pub(super) fn read<R: Read>(
    file: &mut Input<R>,
    topics: &mut Topics<'_>,
) -> Result<(), LogProblem> {
    file.skip(MAGIC_BYTES)?;
    read_records(file, topics)
}

fn read_records<R: Read>(input: &mut Input<R>, topics: &mut Topics<'_>) -> Result<(), LogProblem> {
    loop {
        let begin = input.position();
        let Some(header_bytes) = input.next()? else {
            return Ok(());
        };
        let header_bytes = u64::from(u32::from_le_bytes(header_bytes));
        let header = input.bytes(header_bytes, "a header", MAX_HEADER_BYTES)?;
        let header = Fields::new(header).map_err(|what| input.damaged(what))?;
        let data_bytes = u64::from(u32::from_le_bytes(input.array()?));
        let number = |name| header.number(name).map_err(|what| input.damaged(what));
        match header.byte("op").map_err(|what| input.damaged(what))? {
            op::MESSAGE => {
                let connection = number("conn")?;
                let time = header.array("time").map_err(|what| input.damaged(what))?;
                let encoding = topics.count(connection);
                match encoding.map_err(|what| input.damaged(what))? {
                    None => input.skip(data_bytes)?,
                    Some(encoding) => {
                        let data = input.bytes(data_bytes, "a message", MAX_MESSAGE_BYTES)?;
                        topics.take(recorded_ns(time), &data, encoding, begin)?;
                    }
                }
            }
            op::CONNECTION => {
                let connection = number("conn")?;
                let topic = header.text("topic").map_err(|what| input.damaged(what))?;
                let data = input.bytes(data_bytes, "a connection", MAX_CONNECTION_BYTES)?;
                let of_type = Fields::new(data).and_then(|fields| fields.text("type"));
                let kind = of_type.map(|name| Kind::of(&name, "ros1"));
                kind.and_then(|kind| topics.declare(connection, &topic, &kind, false))
                    .map_err(|what| input.damaged(what))?;
            }
            op::CHUNK if input.is_of_chunk() => {
                return Err(input.damaged("a chunk within a chunk"));
            }
            op::CHUNK => {
                let chunk = Chunk {
                    begin: begin.byte,
                    compression: compression(&header).map_err(|what| input.damaged(what))?,
                    compressed_bytes: data_bytes,
                    content_bytes: u64::from(number("size")?),
                    crc: None,
                };
                let most_bytes = topics.max_chunk_bytes();
                chunk.read(input, most_bytes, |content| read_records(content, topics))?;
            }
            op::BAG | op::INDEX | op::CHUNK_INFO => input.skip(data_bytes)?,
            other => return Err(input.damaged(format!("a record of unknown kind {other:#04x}"))),
        }
    }
}

fn compression(header: &Fields) -> Result<Compression, String> {
    match header.text("compression")?.as_str() {
        "none" => Ok(Compression::None),
        "lz4" => Ok(Compression::Lz4),
        "bz2" => Ok(Compression::Bzip2),
        other => Err(format!(
            "a chunk with compression {other:?}, expected none, lz4 or bz2"
        )),
    }
}

/// Nanoseconds since 1970.
fn recorded_ns(time: [u8; 8]) -> i64 {
    let [a, b, c, d, e, f, g, h] = time;
    let stamp = Stamp {
        seconds: u32::from_le_bytes([a, b, c, d]),
        nanoseconds: u32::from_le_bytes([e, f, g, h]),
    };
    stamp.since_1970_ns().unwrap_or_default()
}

/// Named fields: a length, a name, an equals sign and a value, again and again.
struct Fields(Vec<u8>);

impl Fields {
    /// Fields whose lengths are right.
    fn new(bytes: Vec<u8>) -> Result<Self, String> {
        let mut rest = bytes.as_slice();
        while !rest.is_empty() {
            let next = first_field(rest).filter(|(field, _)| field.contains(&b'='));
            let Some((_, behind)) = next else {
                return Err("a header whose fields do not fit into it".into());
            };
            rest = behind;
        }
        Ok(Self(bytes))
    }

    fn get(&self, name: &str) -> Result<&[u8], String> {
        let mut rest = self.0.as_slice();
        while let Some((field, behind)) = first_field(rest) {
            let value = field.strip_prefix(name.as_bytes());
            if let Some(value) = value.and_then(|value| value.strip_prefix(b"=")) {
                return Ok(value);
            }
            rest = behind;
        }
        Err(format!("a record without the field {name:?}"))
    }

    fn array<const N: usize>(&self, name: &str) -> Result<[u8; N], String> {
        let value = self.get(name)?.try_into();
        value.map_err(|_| format!("a record whose field {name:?} has not {N} bytes"))
    }

    fn byte(&self, name: &str) -> Result<u8, String> {
        self.array(name).map(u8::from_le_bytes)
    }

    fn number(&self, name: &str) -> Result<u32, String> {
        self.array(name).map(u32::from_le_bytes)
    }

    fn text(&self, name: &str) -> Result<String, String> {
        let text = String::from_utf8(self.get(name)?.to_vec());
        text.map_err(|_| format!("a record whose field {name:?} is no text"))
    }
}

/// The first of some fields, and those behind it.
fn first_field(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk()?;
    rest.split_at_checked(u32::from_le_bytes(*length) as usize)
}
