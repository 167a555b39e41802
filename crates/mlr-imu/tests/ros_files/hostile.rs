//! Files that somebody damaged, by accident or not.

use std::io::Write as _;

use lz4_flex::frame::FrameEncoder;
use mlr_imu::{LogLimits, LogProblem, LogTable};
use proptest::prelude::*;

use crate::{golden, read_bytes};

const BAG: &[u8] = b"#ROSBAG V2.0\n";
const MCAP: &[u8] = b"\x89MCAP0\r\n";

fn message(bytes: &[u8]) -> String {
    let problem = read_bytes(bytes, None).unwrap_err();
    assert!(matches!(problem, LogProblem::Container { .. }), "{problem}");
    problem.to_string()
}

/// A record of a bag.
fn record(fields: &[(&str, &[u8])], data: &[u8]) -> Vec<u8> {
    let mut header = Vec::new();
    for (name, value) in fields {
        header.extend((name.len() as u32 + 1 + value.len() as u32).to_le_bytes());
        header.extend(name.as_bytes());
        header.push(b'=');
        header.extend(*value);
    }
    let mut record = (header.len() as u32).to_le_bytes().to_vec();
    record.extend(header);
    record.extend((data.len() as u32).to_le_bytes());
    record.extend(data);
    record
}

fn chunk(compression: &str, states_bytes: u32, data: &[u8]) -> Vec<u8> {
    let fields: [(&str, &[u8]); 3] = [
        ("op", &[5]),
        ("compression", compression.as_bytes()),
        ("size", &states_bytes.to_le_bytes()),
    ];
    [BAG, &record(&fields, data)].concat()
}

/// A record of a kind that is passed over, of a size.
fn padding(bytes: usize) -> Vec<u8> {
    record(&[("op", &[4])], &vec![0; bytes])
}

fn lz4(content: &[u8]) -> Vec<u8> {
    let mut encoder = FrameEncoder::new(Vec::new());
    encoder.write_all(content).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn files_that_are_cut_name_the_byte() {
    for name in [
        "walk-lz4.bag",
        "walk-bz2.bag",
        "several-topics.bag",
        "walk-ros2-zstd.mcap",
        "short-big-endian.mcap",
    ] {
        let whole = std::fs::read(golden(name)).unwrap();
        let topic = name.starts_with("several").then_some("/imu/data");
        for keep in (16..4096)
            .step_by(97)
            .chain((4096..whole.len() - 20_000).step_by(9973))
        {
            match read_bytes(&whole[..keep], topic) {
                Err(LogProblem::Container { position, what }) => {
                    assert!(
                        position.byte <= keep as u64 || position.chunk.is_some(),
                        "{name} {what}"
                    );
                }
                // Nothing was there before the cut.
                Err(LogProblem::NoImuTopic { .. } | LogProblem::Topic { .. }) => {}
                other => panic!("{name} cut at {keep}: {other:?}"),
            }
        }
    }
}

#[test]
fn a_recording_without_chunks_is_read_up_to_where_it_was_cut() {
    let whole = std::fs::read(golden("short-unchunked.mcap")).unwrap();
    let cut = read_bytes(&whole[..50_000], None).unwrap();
    assert!(
        (80..279).contains(&cut.orientation.len()),
        "{}",
        cut.orientation.len()
    );
    assert!(
        cut.notes[0].contains("the last message is cut off"),
        "{:?}",
        cut.notes
    );
}

#[test]
fn lengths_that_lie_are_refused() {
    let huge = u32::MAX.to_le_bytes();
    assert_eq!(
        message(&[BAG, &huge].concat()),
        "byte 17: a header of 4294967295 bytes, more than the 100000 that are read of one"
    );
    // Data that are not there.
    let mut bytes = [BAG, &record(&[("op", &[4])], &[])].concat();
    let end = bytes.len();
    bytes[end - 4..].copy_from_slice(&huge);
    assert!(message(&bytes).contains("the file ends within"));
    let bytes = [BAG, &record(&[("op", &[0x2a])], &[])].concat();
    assert!(message(&bytes).contains("unknown kind 0x2a"));
    let bytes = [BAG, &record(&[("op", &[2])], &[])].concat();
    assert!(message(&bytes).contains("without the field \"conn\""));
    let bytes = [MCAP, &[5], &u64::MAX.to_le_bytes(), &[0; 40]].concat();
    assert!(message(&bytes).contains("connection 0, which is not known"));
    let bytes = [MCAP, &[3], &u64::MAX.to_le_bytes(), &[0; 40]].concat();
    assert!(message(&bytes).contains("a schema of 18446744073709551615 bytes"));
}

#[test]
fn chunks_that_lie_about_what_they_contain_are_refused() {
    let content = padding(1000);
    let whole = content.len() as u32;
    let (none, packed) = (content.clone(), lz4(&content));
    for (bytes, what) in [
        (chunk("none", whole + 1, &none), "contains less than the"),
        (
            chunk("none", whole - 1, &none),
            "the chunk ends within a record",
        ),
        (chunk("lz4", whole + 1, &packed), "contains less than the"),
        (chunk("lz4", 0, &packed), "contains more than the 0 bytes"),
        (
            chunk("lz4", whole, &packed[..packed.len() / 2]),
            "damaged or end early",
        ),
        (chunk("lz4", whole, &none), "damaged or end early"),
        (chunk("bz2", whole, &packed), "damaged or end early"),
        (chunk("zstd", whole, &packed), "expected none, lz4 or bz2"),
        (
            chunk("none", 4_000_000_000, &none),
            "more than the 512000000 that are read",
        ),
        (
            chunk("none", 1000, &chunk("none", 1, &[])[13..]),
            "a chunk within a chunk",
        ),
    ] {
        let message = message(&bytes);
        assert!(message.contains(what), "{message}, expected {what}");
    }
}

#[test]
fn a_chunk_that_decompresses_to_a_thousand_times_as_much_takes_no_memory() {
    // Fifty million zeros within one record that is passed over.
    let content = padding(50_000_000);
    let bytes = chunk("lz4", content.len() as u32, &lz4(&content));
    assert!(bytes.len() < 500_000);
    drop(content);
    let used = allocation_counter::measure(|| {
        let problem = read_bytes(&bytes, None).unwrap_err();
        assert!(
            matches!(problem, LogProblem::NoImuTopic { .. }),
            "{problem}"
        );
    });
    assert!(used.bytes_max < 20_000_000, "{}", used.bytes_max);
    let small = LogLimits {
        max_bytes: 1_000_000,
        ..LogLimits::default()
    };
    let refused = LogTable::from_bytes(bytes.as_slice(), None, small)
        .err()
        .unwrap();
    assert!(
        refused.to_string().contains("more than the 1000000"),
        "{refused}"
    );
}

#[test]
fn damage_within_a_chunk_is_noticed_by_its_check_sum() {
    let mut bytes = std::fs::read(golden("short-big-endian.mcap")).unwrap();
    bytes[20_000] ^= 0x40;
    assert!(message(&bytes).contains("check sum"));
}

#[test]
fn other_files_of_robots_say_what_to_do() {
    for (bytes, what) in [
        (b"#ROSBAG V1.2\nxxxxxxxxx".as_slice(), "rosbag fix"),
        (b"SQLite format 3\0xxxxxxxxx", "ros2 bag convert"),
    ] {
        let message = read_bytes(bytes, None).unwrap_err().to_string();
        assert!(message.contains(what), "{message}");
    }
}

#[test]
fn a_topic_that_is_too_long_is_refused_at_its_first_message_too_many() {
    let limits = LogLimits {
        max_rows: 100,
        ..LogLimits::default()
    };
    let table = LogTable::open(&golden("walk-lz4.bag"), None, limits);
    let message = table.err().unwrap().to_string();
    assert!(
        message.starts_with("message 101 of /imu/data: has more than 100 rows"),
        "{message}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]
    #[test]
    fn no_bytes_panic(
        bytes in prop::collection::vec(any::<u8>(), 0..2000),
        magic in prop::sample::select(vec![BAG, MCAP]),
    ) {
        let _ = read_bytes(&[magic, &bytes].concat(), None);
    }

    #[test]
    fn no_damage_panics(
        name in prop::sample::select(vec![
            "short-unchunked.mcap", "short-big-endian.mcap", "walk-ros2-zstd.mcap",
            "walk-ros1-lz4.mcap", "walk-lz4.bag", "walk-bz2.bag", "several-topics.bag",
        ]),
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
        // Most of what is not numbers is near the beginning.
        reach in prop::sample::select(vec![600, 6000, 60_000]),
    ) {
        let mut bytes = std::fs::read(golden(name)).unwrap();
        let reach = bytes.len().min(reach);
        for (index, value) in damage {
            bytes[index.index(reach)] = value;
        }
        match read_bytes(&bytes, name.starts_with("several").then_some("/imu/data")) {
            Ok(recording) => {
                let angles = recording.orientation.angles_rad();
                prop_assert!(angles.roll.iter().all(|x| x.is_finite()));
            }
            Err(problem) => prop_assert!(problem.to_string().chars().count() < 4000),
        }
    }
}
