//! What chunks contain, decompressed as it is read.

use std::io::{self, BufReader, Read};

use bzip2::read::BzDecoder;
use flate2::CrcReader;
use lz4_flex::frame::FrameDecoder;
use ruzstd::decoding::StreamingDecoder;

use super::{
    super::LogProblem,
    input::{Input, damaged},
};

/// How a chunk is compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Compression {
    None,
    Lz4,
    Bzip2,
    Zstd,
}

/// A chunk whose header has been read.
#[derive(Debug)]
pub(super) struct Chunk {
    /// Where in the file its record begins.
    pub(super) begin: u64,
    pub(super) compression: Compression,
    /// Bytes in the file.
    pub(super) compressed_bytes: u64,
    /// Bytes that it contains, as its header states.
    pub(super) content_bytes: u64,
    /// The CRC-32 of what it contains, if its header states it.
    pub(super) crc: Option<u32>,
}

impl Chunk {
    /// Has what the chunk contains read, and reads the file up to the chunk's end.
    pub(super) fn read<R: Read>(
        &self,
        file: &mut Input<R>,
        most_bytes: u64,
        read: impl FnOnce(&mut Input<Box<dyn Read + '_>>) -> Result<(), LogProblem>,
    ) -> Result<(), LogProblem> {
        if self.content_bytes > most_bytes {
            return Err(file.damaged(format!(
                "a chunk that contains {} bytes, more than the {most_bytes} that are read of one",
                self.content_bytes
            )));
        }
        let begin = file.position();
        let mut compressed = file.by_ref().take(self.compressed_bytes);
        let decompressed = self
            .decompressed(&mut compressed)
            .map_err(|error| damaged(begin, format!("the chunk cannot be read: {error}")))?;
        let mut content = CrcReader::new(decompressed.take(self.content_bytes));
        let mut input = Input::of_chunk(Box::new(&mut content) as Box<dyn Read + '_>, self.begin);
        read(&mut input)?;
        let end = input.position();
        drop(input);
        let sum = content.crc().sum();
        let mut beyond = Input::of_chunk(content.into_inner().into_inner(), self.begin);
        let lies = match end.byte < self.content_bytes {
            true => Some("less"),
            false => (!beyond.is_at_end()?).then_some("more"),
        };
        drop(beyond);
        if let Some(than) = lies {
            let stated = self.content_bytes;
            let what = format!("the chunk contains {than} than the {stated} bytes that it states");
            return Err(damaged(end, what));
        }
        if let Some(expected) = self.crc.filter(|crc| *crc != sum) {
            let what = format!("the chunk's check sum is {sum:08x}, expected {expected:08x}");
            return Err(damaged(end, what));
        }
        let left = compressed.limit();
        file.skip(left)
    }

    fn decompressed<'a>(&self, compressed: impl Read + 'a) -> io::Result<Box<dyn Read + 'a>> {
        // Decompressors read in small pieces.
        let compressed = BufReader::new(compressed);
        Ok(match self.compression {
            Compression::None => Box::new(compressed),
            Compression::Lz4 => Box::new(FrameDecoder::new(compressed)),
            Compression::Bzip2 => Box::new(BzDecoder::new(compressed)),
            Compression::Zstd => {
                Box::new(StreamingDecoder::new(compressed).map_err(io::Error::other)?)
            }
        })
    }
}
