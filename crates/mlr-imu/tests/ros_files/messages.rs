//! What drivers write into messages.

use mlr_imu::{OrientationSource, Recording};

use crate::read_bytes;

/// A message of an MCAP file.
#[derive(Clone, Copy)]
struct Imu {
    stamp: [u32; 2],
    recorded_ns: u64,
    /// x, y, z, w, and the first covariance.
    orientation: [f64; 5],
    rate: [f64; 4],
    acceleration: [f64; 4],
}

impl Imu {
    /// The message of a sensor at 100 Hz whose body rolls.
    fn usual(index: u32) -> Self {
        let half_roll = 0.05 * (f64::from(index) * 0.06).sin();
        Self {
            stamp: [1_700_000_000 + index / 100, index % 100 * 10_000_000],
            recorded_ns: 1_700_000_000_002_000_000 + 10_000_000 * u64::from(index),
            orientation: [half_roll.sin(), 0.0, 0.0, half_roll.cos(), 0.0],
            rate: [0.6, 0.0, 0.0, 0.0],
            acceleration: [0.0, 0.0, 9.81, 0.0],
        }
    }

    fn to_cdr(self) -> Vec<u8> {
        let mut bytes = vec![0, 1, 0, 0];
        for word in [self.stamp[0], self.stamp[1], 4] {
            bytes.extend(word.to_le_bytes());
        }
        bytes.extend(b"imu\0");
        for values in [&self.orientation[..], &self.rate, &self.acceleration] {
            for value in values.iter().chain(&[0.0; 8]) {
                bytes.extend(value.to_le_bytes());
            }
        }
        bytes
    }
}

/// Bytes behind their number.
fn counted(bytes: &[u8]) -> Vec<u8> {
    [&(bytes.len() as u32).to_le_bytes(), bytes].concat()
}

fn record(kind: u8, parts: &[&[u8]]) -> Vec<u8> {
    let content = parts.concat();
    [&[kind], &(content.len() as u64).to_le_bytes()[..], &content].concat()
}

/// An MCAP file with one topic in one chunk, without an index.
fn file(type_name: &str, encoding: &str, messages: impl IntoIterator<Item = Imu>) -> Vec<u8> {
    let id = 5_u16.to_le_bytes();
    let names = [type_name, "ros2msg", ""].map(|text| counted(text.as_bytes()));
    let schema = record(3, &[&id, &names.concat()]);
    let names = ["/imu", encoding, ""].map(|text| counted(text.as_bytes()));
    let channel = record(4, &[&id, &id, &names.concat()]);
    let mut content = [schema, channel].concat();
    for message in messages {
        let times = [message.recorded_ns.to_le_bytes(); 2].concat();
        content.extend(record(5, &[&id, &[0; 4], &times, &message.to_cdr()]));
    }
    let bytes = (content.len() as u64).to_le_bytes();
    let chunk = record(6, &[&[0; 16], &bytes, &[0; 8], &bytes, &content]);
    let header = record(1, &[&[0; 8]]);
    [
        b"\x89MCAP0\r\n",
        &header[..],
        &chunk,
        &record(15, &[&[0; 4]]),
    ]
    .concat()
}

fn read(messages: impl Fn(u32) -> Imu) -> Recording {
    let bytes = file("sensor_msgs/msg/Imu", "cdr", (0..500).map(messages));
    read_bytes(&bytes, None).unwrap()
}

#[test]
fn the_time_is_that_of_the_header() {
    let recording = read(Imu::usual);
    assert_eq!(recording.notes, [""; 0]);
    assert_eq!(recording.orientation.times_s()[..3], [0.0, 0.01, 0.02]);
    assert_eq!(recording.source, OrientationSource::Recorded);
    assert!((recording.orientation.angles_rad().roll[26] - 0.1 * 1.56_f64.sin()).abs() < 1e-12);
}

#[test]
fn where_headers_say_no_time_that_of_recording_is_taken() {
    type Stamps = fn(u32) -> [u32; 2];
    let cases: [(Stamps, &str); 5] = [
        (|_| [0, 0], "are zero"),
        (|_| [1_700_000_000, 5], "make no sense"),
        (|index| [1_700_000_000 - index, 0], "make no sense"),
        (|index| [1_700_000_000 + index, 0], "make no sense"),
        (
            |index| [1_700_000_000, 2_000_000_000 + index],
            "make no sense",
        ),
    ];
    for (stamp, why) in cases {
        let recording = read(|index| Imu {
            stamp: stamp(index),
            ..Imu::usual(index)
        });
        assert!(recording.notes[0].contains(why), "{:?}", recording.notes);
        assert_eq!(recording.orientation.times_s()[499], 4.99);
    }
}

#[test]
fn single_messages_without_a_time_are_left_out() {
    let recording = read(|index| Imu {
        stamp: if index == 0 {
            [0, 0]
        } else {
            Imu::usual(index).stamp
        },
        ..Imu::usual(index)
    });
    assert_eq!(recording.orientation.len(), 499);
    assert!(
        recording.notes[0].contains("message 1 of /imu, column \"t_s\""),
        "{:?}",
        recording.notes
    );
}

#[test]
fn an_orientation_that_is_not_known_is_not_believed() {
    for (orientation, note) in [
        ([0.1, 0.2, 0.3, 0.4, -1.0], None),
        ([0.0; 5], Some("zero in every message")),
        ([0.0, 0.0, 0.0, 1.0, 0.01], Some("never turns")),
    ] {
        let recording = read(|index| Imu {
            orientation,
            ..Imu::usual(index)
        });
        assert_eq!(recording.source, OrientationSource::Fused);
        match note {
            None => assert_eq!(recording.notes, [""; 0]),
            Some(note) => assert!(recording.notes[0].contains(note), "{:?}", recording.notes),
        }
    }
    // From the middle on.
    let recording = read(|index| Imu {
        orientation: if index < 250 {
            [0.0, 0.0, 0.0, 0.0, -1.0]
        } else {
            Imu::usual(index).orientation
        },
        ..Imu::usual(index)
    });
    assert_eq!(recording.source, OrientationSource::Fused);
    assert!(recording.notes[0].contains("250 of 500 messages have no orientation"));
}

#[test]
fn raw_samples_that_are_not_known_are_not_read() {
    let recording = read(|index| Imu {
        rate: [0.0, 0.0, 0.0, -1.0],
        ..Imu::usual(index)
    });
    assert_eq!(
        (recording.source, recording.raw),
        (OrientationSource::Recorded, None)
    );
    let bytes = file(
        "sensor_msgs/msg/Imu",
        "cdr",
        (0..500).map(|index| Imu {
            rate: [0.0, 0.0, 0.0, -1.0],
            orientation: [0.0, 0.0, 0.0, 0.0, -1.0],
            ..Imu::usual(index)
        }),
    );
    let message = read_bytes(&bytes, None).unwrap_err().to_string();
    assert!(message.contains("neither orientations nor"), "{message}");
}

#[test]
fn messages_that_make_no_sense_are_named() {
    let broken = |index| Imu {
        orientation: if index == 7 {
            [2.0; 5]
        } else {
            Imu::usual(index).orientation
        },
        ..Imu::usual(index)
    };
    let recording = read(broken);
    assert!(
        recording.notes[0].contains("message 8 of /imu: the quaternion"),
        "{:?}",
        recording.notes
    );
    let bytes = file("sensor_msgs/msg/Imu", "cdr", (0..50).map(broken));
    let message = read_bytes(&bytes, None).unwrap_err().to_string();
    assert!(
        message.starts_with("message 8 of /imu: the quaternion"),
        "{message}"
    );
}

#[test]
fn other_types_and_encodings_are_named() {
    let usual = || (0..20).map(Imu::usual);
    let bytes = file("geometry_msgs/msg/Twist", "cdr", usual());
    let message = read_bytes(&bytes, None).unwrap_err().to_string();
    assert!(
        message.contains("found /imu (geometry_msgs/msg/Twist)"),
        "{message}"
    );
    let bytes = file("sensor_msgs/msg/Imu", "json", usual());
    let message = read_bytes(&bytes, None).unwrap_err().to_string();
    assert!(
        message.contains("as \"json\", expected cdr or ros1"),
        "{message}"
    );
    // Of ROS 1, the frame's name longer than the first message.
    let mut bytes = file("sensor_msgs/Imu", "ros1", usual());
    let name = b"\x04\0\0\0imu\0";
    let at = bytes.windows(name.len()).position(|bytes| bytes == name);
    bytes[at.unwrap() + 1] = 0xff;
    let message = read_bytes(&bytes, None).unwrap_err().to_string();
    assert!(
        message.contains("of the chunk at byte") && message.contains("message 1 of /imu"),
        "{message}"
    );
    let bytes = file("sensor_msgs/msg/Imu", "cdr", []);
    let message = read_bytes(&bytes, None).unwrap_err().to_string();
    assert!(
        message.contains("has no messages of sensor_msgs/Imu"),
        "{message}"
    );
}
