//! Bytes whose position is known, in bounded memory.

use std::io::{self, ErrorKind, Read};

use super::super::{LogProblem, Position};

/// Bytes of a file, or of what a chunk of it contains.
pub(super) struct Input<R> {
    bytes: R,
    position: Position,
    has_ended: bool,
}

impl<R: Read> Input<R> {
    pub(super) fn of_file(bytes: R) -> Self {
        Self {
            bytes,
            position: Position {
                byte: 0,
                chunk: None,
            },
            has_ended: false,
        }
    }

    /// What the chunk that begins there contains.
    pub(super) fn of_chunk(bytes: R, begin: u64) -> Self {
        Self {
            bytes,
            position: Position {
                byte: 0,
                chunk: Some(begin),
            },
            has_ended: false,
        }
    }

    pub(super) fn position(&self) -> Position {
        self.position
    }

    pub(super) fn is_of_chunk(&self) -> bool {
        self.position.chunk.is_some()
    }

    /// Whether reading failed because there was no more.
    pub(super) fn has_ended(&self) -> bool {
        self.has_ended
    }

    /// That something is wrong here.
    pub(super) fn damaged(&self, what: impl Into<String>) -> LogProblem {
        damaged(self.position, what)
    }

    /// The next bytes; `None` where there are no more, not even the first of them.
    pub(super) fn next<const N: usize>(&mut self) -> Result<Option<[u8; N]>, LogProblem> {
        let begin = self.position;
        let (mut bytes, mut filled) = ([0; N], 0);
        while filled < N {
            match self.read(&mut bytes[filled..]) {
                Ok(0) if filled == 0 => return Ok(None),
                Ok(0) => return Err(self.ends_early(begin)),
                Ok(count) => filled += count,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(self.failed(error)),
            }
        }
        Ok(Some(bytes))
    }

    /// A record's next bytes.
    pub(super) fn array<const N: usize>(&mut self) -> Result<[u8; N], LogProblem> {
        let begin = self.position;
        match self.next()? {
            Some(bytes) => Ok(bytes),
            None => Err(self.ends_early(begin)),
        }
    }

    /// Bytes of this number. A number that lies takes no more memory than there are bytes.
    pub(super) fn bytes(
        &mut self,
        length: u64,
        what: &str,
        most: u64,
    ) -> Result<Vec<u8>, LogProblem> {
        let begin = self.position;
        if length > most {
            return Err(self.damaged(format!(
                "{what} of {length} bytes, more than the {most} that are read of one"
            )));
        }
        let mut bytes = Vec::new();
        let read = self.by_ref().take(length).read_to_end(&mut bytes);
        read.map_err(|error| self.failed(error))?;
        if (bytes.len() as u64) < length {
            return Err(self.ends_early(begin));
        }
        Ok(bytes)
    }

    /// Passes over bytes.
    pub(super) fn skip(&mut self, length: u64) -> Result<(), LogProblem> {
        let begin = self.position;
        let skipped = io::copy(&mut self.by_ref().take(length), &mut io::sink());
        let skipped = skipped.map_err(|error| self.failed(error))?;
        if skipped < length {
            return Err(self.ends_early(begin));
        }
        Ok(())
    }

    /// Whether there are no more bytes, which takes one if there are.
    pub(super) fn is_at_end(&mut self) -> Result<bool, LogProblem> {
        Ok(self.next::<1>()?.is_none())
    }

    /// What a failure to read means.
    fn failed(&self, error: io::Error) -> LogProblem {
        let of_the_content = self.is_of_chunk()
            || matches!(
                error.kind(),
                // What the gzip decoder reports for data cut short or damaged.
                ErrorKind::UnexpectedEof | ErrorKind::InvalidData | ErrorKind::InvalidInput
            );
        match of_the_content {
            true => self.damaged(format!("the data are damaged or end early: {error}")),
            false => LogProblem::Io(error),
        }
    }

    fn ends_early(&mut self, begin: Position) -> LogProblem {
        self.has_ended = true;
        let what = match self.is_of_chunk() {
            true => "the chunk ends within a record that begins here",
            false => {
                "the file ends within what begins here; `rosbag reindex` or `mcap recover` keeps \
                 what is whole"
            }
        };
        damaged(begin, what)
    }
}

impl<R: Read> Read for Input<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.bytes.read(buffer)?;
        self.position.byte += count as u64;
        Ok(count)
    }
}

/// That something is wrong there.
pub(super) fn damaged(position: Position, what: impl Into<String>) -> LogProblem {
    LogProblem::Container {
        position,
        what: what.into(),
    }
}
