//! Which format a file has, whatever its name.

use std::io::{self, BufReader, Cursor, Read};

use super::ros::MCAP_MAGIC;

/// The first bytes of every gzip file (RFC 1952).
const GZIP: &[u8] = &[0x1f, 0x8b];
const BAG: &[u8] = b"#ROSBAG V2.0\n";
const ANY_BAG: &[u8] = b"#ROSBAG V";
const SQLITE: &[u8] = b"SQLite format 3\0";
/// Bytes that tell.
const LONGEST: u64 = 16;

/// A format, as far as the first bytes tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Text,
    Gzip,
    /// Of ROS 1, version 2.0.
    Bag,
    /// Of ROS 1, of another version.
    OtherBag,
    Mcap,
    /// What ROS 2 wrote its bags to before MCAP.
    Sqlite,
}

impl Format {
    /// The format of some bytes, and the same bytes.
    pub(super) fn told_by(mut bytes: impl Read) -> io::Result<(Self, BufReader<impl Read>)> {
        let mut start = Vec::new();
        bytes.by_ref().take(LONGEST).read_to_end(&mut start)?;
        let format = Self::of(&start);
        Ok((format, BufReader::new(Cursor::new(start).chain(bytes))))
    }

    fn of(start: &[u8]) -> Self {
        [
            (GZIP, Self::Gzip),
            (BAG, Self::Bag),
            (ANY_BAG, Self::OtherBag),
            (MCAP_MAGIC, Self::Mcap),
            (SQLITE, Self::Sqlite),
        ]
        .into_iter()
        .find(|(magic, _)| start.starts_with(magic))
        .map_or(Self::Text, |(_, format)| format)
    }
}
