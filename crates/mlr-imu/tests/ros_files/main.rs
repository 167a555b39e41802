//! Bags of ROS 1 and MCAP files: those that the libraries of these formats wrote, those that we
//! write, and those that somebody damaged.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod hostile;
mod messages;

use std::path::PathBuf;

use mlr_imu::{
    Columns, LogLimits, LogProblem, LogTable, OrientationSource, Recording, write_recording,
};

/// Files that `tools/formats/make.py` wrote.
fn golden(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../data/golden/formats");
    folder.join(name)
}

fn read(name: &str, topic: Option<&str>) -> Result<Recording, LogProblem> {
    let table = LogTable::open(&golden(name), topic, LogLimits::default())?;
    Recording::from_table(table, &Columns::default())
}

fn read_bytes(bytes: &[u8], topic: Option<&str>) -> Result<Recording, LogProblem> {
    let table = LogTable::from_bytes(bytes, topic, LogLimits::default())?;
    Recording::from_table(table, &Columns::default())
}

/// The same samples, as far as numbers between angles and quaternions are the same.
fn assert_same(ours: &Recording, theirs: &Recording, name: &str) {
    let rows = ours.orientation.len();
    assert!(
        rows > 150 && rows <= theirs.orientation.len(),
        "{name}: {rows}"
    );
    let near = |ours: f64, theirs: f64| {
        assert!((ours - theirs).abs() < 1e-9, "{name}: {ours} {theirs}");
    };
    let (our_angles, their_angles) = (
        ours.orientation.angles_rad(),
        theirs.orientation.angles_rad(),
    );
    let (our_raw, their_raw) = (ours.raw.as_ref().unwrap(), theirs.raw.as_ref().unwrap());
    for row in 0..rows {
        near(
            ours.orientation.times_s()[row],
            theirs.orientation.times_s()[row],
        );
        near(our_angles.roll[row], their_angles.roll[row]);
        near(our_angles.pitch[row], their_angles.pitch[row]);
        near(our_angles.yaw[row], their_angles.yaw[row]);
        assert_eq!(
            our_raw.accelerations_mps2[row],
            their_raw.accelerations_mps2[row]
        );
        assert_eq!(
            our_raw.angular_rates_radps[row],
            their_raw.angular_rates_radps[row]
        );
    }
    assert_eq!(ours.source, OrientationSource::Recorded, "{name}");
}

#[test]
fn what_the_libraries_wrote_is_read_as_the_table_is() {
    let table = read("walk.csv.gz", None).unwrap();
    for (name, rows) in [
        ("walk-lz4.bag", table.orientation.len()),
        ("walk-bz2.bag", table.orientation.len()),
        ("walk-ros2-zstd.mcap", table.orientation.len()),
        ("walk-ros1-lz4.mcap", table.orientation.len()),
        ("short-big-endian.mcap", 279),
        ("short-unchunked.mcap", 279),
    ] {
        let recording = read(name, None).unwrap();
        assert_eq!(recording.orientation.len(), rows, "{name}");
        assert_same(&recording, &table, name);
        assert!(recording.notes.is_empty(), "{name}: {:?}", recording.notes);
    }
}

#[test]
fn of_several_topics_one_must_be_named() {
    let message = read("several-topics.bag", None).unwrap_err().to_string();
    assert_eq!(
        message,
        "has several topics of sensor_msgs/Imu: /imu/data (140 messages), /imu/data_raw \
         (279 messages); choose one with --topic NAME"
    );
    let table = read("walk.csv.gz", None).unwrap();
    // With the slash or without.
    for topic in ["/imu/data_raw", "imu/data_raw"] {
        let raw = read("several-topics.bag", Some(topic)).unwrap();
        assert_eq!(raw.source, OrientationSource::Fused);
        let (ours, theirs) = (raw.raw.unwrap(), table.raw.as_ref().unwrap());
        assert_eq!(
            ours.accelerations_mps2[..],
            theirs.accelerations_mps2[..279]
        );
    }
    let fused = read("several-topics.bag", Some("/imu/data")).unwrap();
    assert_eq!(fused.source, OrientationSource::Recorded);
    assert_eq!(fused.orientation.len(), 140);

    let message = read("several-topics.bag", Some("/imu"))
        .unwrap_err()
        .to_string();
    assert!(
        message.starts_with("topic \"/imu\" is not there; topics of"),
        "{message}"
    );
    let message = read("several-topics.bag", Some("rosout"))
        .unwrap_err()
        .to_string();
    assert!(message.contains("is of std_msgs/String"), "{message}");
}

#[test]
fn a_table_has_no_topics() {
    let recording = read("walk.csv.gz", Some("/imu/data")).unwrap();
    assert_eq!(
        recording.notes,
        ["--topic: a table has no topics; read without it"]
    );
}

#[test]
fn columns_of_messages_are_mapped_like_those_of_tables() {
    let mut columns = Columns::default();
    columns.rename("gz=-gz_radps").unwrap();
    let table = LogTable::open(&golden("walk-lz4.bag"), None, LogLimits::default()).unwrap();
    let turned = Recording::from_table(table, &columns).unwrap().raw.unwrap();
    let plain = read("walk-lz4.bag", None).unwrap().raw.unwrap();
    assert_eq!(
        turned.angular_rates_radps[9].z,
        -plain.angular_rates_radps[9].z
    );

    columns.rename("ax=acc_x").unwrap();
    let table = LogTable::open(&golden("walk-lz4.bag"), None, LogLimits::default()).unwrap();
    let notes = Recording::from_table(table, &columns).unwrap().notes;
    assert!(notes[0].contains("no column \"acc_x\""), "{notes:?}");
}

#[test]
fn gzipped_bags_are_read_too() {
    use std::io::Write as _;
    let bytes = std::fs::read(golden("walk-lz4.bag")).unwrap();
    let mut zipped = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    zipped.write_all(&bytes).unwrap();
    let zipped = zipped.finish().unwrap();
    assert_eq!(
        read_bytes(&zipped, None).unwrap(),
        read("walk-lz4.bag", None).unwrap()
    );
    let message = read_bytes(&zipped[..zipped.len() / 2], None)
        .unwrap_err()
        .to_string();
    assert!(message.starts_with("byte "), "{message}");
}

#[test]
fn what_is_written_is_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let begin_ns = 1_700_000_000_123_456_789;
    let both = read("walk.csv.gz", None).unwrap();
    let only_raw = read("several-topics.bag", Some("/imu/data_raw")).unwrap();
    let in_body_axes = Recording {
        in_body_axes: true,
        ..both.clone()
    };
    for (index, recording) in [both, only_raw, in_body_axes].iter().enumerate() {
        for ending in ["csv", "csv.gz", "mcap"] {
            let path = folder.path().join(format!("{index}.{ending}"));
            write_recording(&path, recording, begin_ns).unwrap();
            let table = LogTable::open(&path, None, LogLimits::default()).unwrap();
            if ending == "mcap" {
                assert_eq!(table.messages().unwrap().begin_ns(), begin_ns);
            }
            let again = Recording::from_table(table, &Columns::default()).unwrap();
            assert_eq!(again.source, recording.source);
            assert_eq!(again.in_body_axes, recording.in_body_axes);
            assert_eq!(again.orientation.len(), recording.orientation.len());
            if recording.source == OrientationSource::Recorded {
                assert_same(&again, recording, ending);
            } else {
                let (ours, theirs) = (again.raw.unwrap(), recording.raw.as_ref().unwrap());
                assert_eq!(ours.angular_rates_radps, theirs.angular_rates_radps);
                assert_eq!(ours.accelerations_mps2, theirs.accelerations_mps2);
            }
            let error = write_recording(&path, recording, begin_ns).unwrap_err();
            assert!(matches!(error.problem, LogProblem::Exists), "{error}");
        }
    }
    let unknown = folder.path().join("walk.bag");
    let recording = read("walk-lz4.bag", None).unwrap();
    let error = write_recording(&unknown, &recording, 0).unwrap_err();
    assert!(
        matches!(error.problem, LogProblem::UnknownFormat),
        "{error}"
    );
}
