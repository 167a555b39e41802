//! MCAP (<https://mcap.dev/spec>).
//!
//! The readers of the crate `mcap` hold each record as a whole, pictures included, do not tell
//! where in the file it is, and decompress with C libraries. What is left of the crate then is the
//! layout of a few records, for which it would bring in a dozen others.

use std::{collections::HashMap, io::Read};

use super::{
    super::LogProblem,
    chunk::{Chunk, Compression},
    imu_message::MAX_MESSAGE_BYTES,
    input::Input,
    mcap_records::{Channel, MAGIC, Schema, op},
    topics::{Kind, Topics},
};

/// The longest record of a schema or a channel.
const MAX_DECLARATION_BYTES: u64 = 10_000_000;
/// The header of a chunk without the name of its compression, and the longest such name.
const CHUNK_HEADER_BYTES: u64 = 40;
const MAX_COMPRESSION_BYTES: u64 = 16;
/// A message's channel, sequence number, and times of recording and publication.
const MESSAGE_HEADER_BYTES: u64 = 22;
/// Where a channel says that the mounting of the sensor has been applied to its messages.
pub(super) const AXES: (&str, &str) = ("mlr.axes", "body");

/// Characters of a name that are kept.
const MAX_NAME: usize = 200;

/// What messages of the channels of each schema are.
type Schemas = HashMap<u16, String>;

/// Reads a file from its beginning.
pub(super) fn read<R: Read>(
    file: &mut Input<R>,
    topics: &mut Topics<'_>,
) -> Result<(), LogProblem> {
    file.skip(MAGIC.len() as u64)?;
    let end = read_records(file, topics, &mut Schemas::new())?;
    if end == End::OfBytes {
        topics.note("the end of the file is missing: what was recorded last may be lost".into());
    }
    Ok(())
}

/// What comes behind the last message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    /// The record that closes the data.
    OfData,
    /// Nothing.
    OfBytes,
}

fn read_records<R: Read>(
    input: &mut Input<R>,
    topics: &mut Topics<'_>,
    schemas: &mut Schemas,
) -> Result<End, LogProblem> {
    loop {
        let begin = input.position();
        let Some([kind]) = input.next()? else {
            return Ok(End::OfBytes);
        };
        let read = read_record(input, begin.byte, kind, topics, schemas);
        match read {
            Ok(()) if kind == op::DATA_END => return Ok(End::OfData),
            Ok(()) => {}
            // A recording that power cut short ends so, where it has no chunks.
            Err(_) if kind == op::MESSAGE && input.has_ended() && !input.is_of_chunk() => {
                topics.note(format!("{begin}: the last message is cut off and left out"));
                return Ok(End::OfBytes);
            }
            Err(problem) => return Err(problem),
        }
    }
}

fn read_record<R: Read>(
    input: &mut Input<R>,
    begin: u64,
    kind: u8,
    topics: &mut Topics<'_>,
    schemas: &mut Schemas,
) -> Result<(), LogProblem> {
    let position = input.position();
    let length = u64::from_le_bytes(input.array()?);
    match kind {
        op::SCHEMA => {
            let record = input.bytes(length, "a schema", MAX_DECLARATION_BYTES)?;
            let schema = Schema::read(&record);
            let schema = schema.ok_or_else(|| input.damaged("a schema that makes no sense"))?;
            schemas.insert(schema.id, schema.name.chars().take(MAX_NAME).collect());
            Ok(())
        }
        op::CHANNEL => {
            let record = input.bytes(length, "a channel", MAX_DECLARATION_BYTES)?;
            let channel = Channel::read(&record);
            let channel = channel.ok_or_else(|| input.damaged("a channel that makes no sense"))?;
            let type_name = schemas.get(&channel.schema_id).map_or("", String::as_str);
            let encoding: String = channel.message_encoding.chars().take(MAX_NAME).collect();
            let kind = Kind::of(type_name, &encoding);
            let in_body_axes = channel.metadata.contains(&AXES);
            topics
                .declare(channel.id.into(), channel.topic, &kind, in_body_axes)
                .map_err(|what| input.damaged(what))
        }
        op::MESSAGE => {
            let Some(data_bytes) = length.checked_sub(MESSAGE_HEADER_BYTES) else {
                return Err(input.damaged(format!("a message of {length} bytes")));
            };
            let channel = u16::from_le_bytes(input.array()?);
            // The sequence number, and behind the time of recording that of publication.
            input.skip(4)?;
            let at_ns = u64::from_le_bytes(input.array()?);
            input.skip(8)?;
            let encoding = topics.count(channel.into());
            match encoding.map_err(|what| input.damaged(what))? {
                None => input.skip(data_bytes),
                Some(encoding) => {
                    let data = input.bytes(data_bytes, "a message", MAX_MESSAGE_BYTES)?;
                    let at_ns = i64::try_from(at_ns).unwrap_or_default();
                    topics.take(at_ns, &data, encoding, position)
                }
            }
        }
        op::CHUNK if input.is_of_chunk() => Err(input.damaged("a chunk within a chunk")),
        op::CHUNK => {
            let chunk = chunk(input, begin, length)?;
            let most_bytes = topics.max_chunk_bytes();
            chunk.read(input, most_bytes, |content| {
                read_records(content, topics, schemas).map(|_| ())
            })
        }
        0 => Err(input.damaged("a record of kind 0, which there is not")),
        _ => input.skip(length),
    }
}

/// Reads a chunk's header.
fn chunk<R: Read>(input: &mut Input<R>, begin: u64, length: u64) -> Result<Chunk, LogProblem> {
    // The times of its first and last message.
    input.skip(16)?;
    let content_bytes = u64::from_le_bytes(input.array()?);
    let crc = u32::from_le_bytes(input.array()?);
    let name_bytes = u64::from(u32::from_le_bytes(input.array()?));
    let name = input.bytes(
        name_bytes,
        "the name of a compression",
        MAX_COMPRESSION_BYTES,
    )?;
    let compressed_bytes = u64::from_le_bytes(input.array()?);
    if (CHUNK_HEADER_BYTES + name_bytes).checked_add(compressed_bytes) != Some(length) {
        return Err(input.damaged(format!(
            "a chunk of {length} bytes whose data have {compressed_bytes}"
        )));
    }
    let compression = match name.as_slice() {
        b"" => Compression::None,
        b"lz4" => Compression::Lz4,
        b"zstd" => Compression::Zstd,
        other => {
            let name = String::from_utf8_lossy(other);
            return Err(input.damaged(format!(
                "a chunk with compression {name:?}, expected none, lz4 or zstd"
            )));
        }
    };
    Ok(Chunk {
        begin,
        compression,
        compressed_bytes,
        content_bytes,
        crc: (crc != 0).then_some(crc),
    })
}
