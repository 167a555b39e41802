//! The records of MCAP, as far as they are needed (<https://mcap.dev/spec>).
//!
//! All numbers are little-endian; a text is its length and its bytes; so is a map, of its pairs.

/// The first and the last bytes of a file.
pub(in super::super) const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// What a record is.
pub(super) mod op {
    pub(in super::super) const HEADER: u8 = 0x01;
    pub(in super::super) const FOOTER: u8 = 0x02;
    pub(in super::super) const SCHEMA: u8 = 0x03;
    pub(in super::super) const CHANNEL: u8 = 0x04;
    pub(in super::super) const MESSAGE: u8 = 0x05;
    pub(in super::super) const CHUNK: u8 = 0x06;
    pub(in super::super) const MESSAGE_INDEX: u8 = 0x07;
    pub(in super::super) const CHUNK_INDEX: u8 = 0x08;
    pub(in super::super) const STATISTICS: u8 = 0x0b;
    pub(in super::super) const DATA_END: u8 = 0x0f;
}

/// A record's kind and length, before what is in it.
pub(super) const FRAME_BYTES: u64 = 9;

/// A type of messages.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Schema<'a> {
    pub(super) id: u16,
    pub(super) name: &'a str,
}

/// A topic.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Channel<'a> {
    pub(super) id: u16,
    pub(super) schema_id: u16,
    pub(super) topic: &'a str,
    pub(super) message_encoding: &'a str,
    pub(super) metadata: Vec<(&'a str, &'a str)>,
}

impl<'a> Schema<'a> {
    pub(super) fn read(record: &'a [u8]) -> Option<Self> {
        let mut fields = Fields(record);
        Some(Self {
            id: fields.u16()?,
            name: fields.text()?,
        })
    }
}

impl<'a> Channel<'a> {
    pub(super) fn read(record: &'a [u8]) -> Option<Self> {
        let mut fields = Fields(record);
        let mut channel = Self {
            id: fields.u16()?,
            schema_id: fields.u16()?,
            topic: fields.text()?,
            message_encoding: fields.text()?,
            metadata: Vec::new(),
        };
        let mut pairs = Fields(fields.bytes()?);
        while !pairs.0.is_empty() {
            channel.metadata.push((pairs.text()?, pairs.text()?));
        }
        Some(channel)
    }
}

/// What wrote a file, by its header.
pub(super) fn library(header: &[u8]) -> Option<&str> {
    let mut fields = Fields(header);
    fields.text()?;
    fields.text()
}

/// The fields of a record, one after the other.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*taken)
    }

    fn u16(&mut self) -> Option<u16> {
        self.take().map(u16::from_le_bytes)
    }

    fn bytes(&mut self) -> Option<&'a [u8]> {
        let length = u32::from_le_bytes(self.take()?) as usize;
        let (bytes, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(bytes)
    }

    fn text(&mut self) -> Option<&'a str> {
        str::from_utf8(self.bytes()?).ok()
    }
}

/// Puts a record together.
#[derive(Debug, Default)]
pub(super) struct NewRecord(Vec<u8>);

impl NewRecord {
    pub(super) fn u16(mut self, number: u16) -> Self {
        self.0.extend(number.to_le_bytes());
        self
    }

    pub(super) fn u32(mut self, number: u32) -> Self {
        self.0.extend(number.to_le_bytes());
        self
    }

    pub(super) fn u64(mut self, number: u64) -> Self {
        self.0.extend(number.to_le_bytes());
        self
    }

    pub(super) fn text(self, text: &str) -> Self {
        self.bytes(text.as_bytes())
    }

    /// Bytes behind their number, as `u32`.
    pub(super) fn bytes(self, bytes: &[u8]) -> Self {
        let mut longer = self.u32(bytes.len() as u32);
        longer.0.extend(bytes);
        longer
    }

    /// Bytes as they are.
    pub(super) fn raw(mut self, bytes: &[u8]) -> Self {
        self.0.extend(bytes);
        self
    }

    /// What is in it.
    pub(super) fn content(self) -> Vec<u8> {
        self.0
    }

    /// The record of a kind, as it stands in a file.
    pub(super) fn of_kind(self, kind: u8) -> Vec<u8> {
        let mut record = Vec::with_capacity(self.0.len() + FRAME_BYTES as usize);
        record.push(kind);
        record.extend((self.0.len() as u64).to_le_bytes());
        record.extend(self.0);
        record
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let pairs = NewRecord::default().text("mlr.axes").text("body").content();
        let record = NewRecord::default()
            .u16(3)
            .u16(7)
            .text("/imu")
            .text("cdr")
            .bytes(&pairs);
        let bytes = record.content();
        let channel = Channel::read(&bytes).unwrap();
        assert_eq!((channel.id, channel.schema_id), (3, 7));
        assert_eq!((channel.topic, channel.message_encoding), ("/imu", "cdr"));
        assert_eq!(channel.metadata, [("mlr.axes", "body")]);
        for keep in 0..bytes.len() {
            assert_eq!(Channel::read(&bytes[..keep]), None, "{keep}");
        }
    }
}
