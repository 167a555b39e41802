//! Bags of ROS 1 and MCAP files wherever a log is read, and `mlr-ga convert`.

use std::{fs, path::PathBuf};

use serde_json::Value;

use crate::program::{Folder, HEADER, standing_then_rocking};

/// A file that the libraries of these formats wrote.
fn golden(name: &str) -> String {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../data/golden/formats");
    folder.join(name).display().to_string()
}

/// The numbers of an answer of `detect`.
fn detected(folder: &Folder, log: &str) -> [f64; 2] {
    let answer = folder.succeeds(&["detect", log, "--json"]);
    let answer: Value = serde_json::from_str(&answer).unwrap();
    ["motion_start_s", "max_fluctuation_deg"].map(|name| answer[name].as_f64().unwrap())
}

fn assert_near(ours: [f64; 2], theirs: [f64; 2], name: &str) {
    for (ours, theirs) in ours.into_iter().zip(theirs) {
        assert!((ours - theirs).abs() < 1e-6, "{name}: {ours} {theirs}");
    }
}

#[test]
fn the_answer_is_that_of_the_table() {
    let folder = Folder::new();
    let expected = detected(&folder, &golden("walk.csv.gz"));
    for name in ["walk-lz4.bag", "walk-ros2-zstd.mcap"] {
        assert_near(detected(&folder, &golden(name)), expected, name);
    }
    let bag = fs::read(golden("walk-bz2.bag")).unwrap();
    let mut program = folder.program(&["detect", "-"]);
    let output = program.write_stdin(bag).output().unwrap();
    assert!(output.status.success(), "{output:?}");
}

#[test]
fn several_topics_are_listed_with_their_messages() {
    let folder = Folder::new();
    let bag = golden("several-topics.bag");
    let listed =
        "/imu/data (140 messages), /imu/data_raw (279 messages); choose one with --topic NAME";
    folder.fails(&["identify", &bag], 2, &["several-topics.bag", listed]);
    let wrong = ["detect", &bag, "--topic", "/rosout"];
    folder.fails(&wrong, 2, &["topic \"/rosout\" is of std_msgs/String"]);
    // It is read, and only stands in these two seconds.
    let right = ["detect", &bag, "--topic", "imu/data"];
    folder.fails(&right, 1, &["no motion"]);
}

#[test]
fn what_is_damaged_names_file_and_byte() {
    let folder = Folder::new();
    let whole = fs::read(golden("walk-lz4.bag")).unwrap();
    let cut = folder.write("cut.bag", &whole[..100_000]);
    folder.fails(
        &["detect", &cut],
        2,
        &["cut.bag: byte ", "of the chunk at byte 4109"],
    );
    let mut bytes = whole.clone();
    bytes[13..17].copy_from_slice(&u32::MAX.to_le_bytes());
    let huge = folder.write("huge.bag", &bytes);
    folder.fails(
        &["detect", &huge],
        2,
        &["huge.bag: byte 17: a header of 4294967295 bytes"],
    );
    let wrong = folder.write("wrong.mcap", b"\x89MCAP1\r\n and more");
    folder.fails(&["detect", &wrong], 2, &["wrong.mcap: line 1"]);
}

#[test]
fn a_log_is_converted_there_and_back() {
    let folder = Folder::new();
    let [mcap, csv] = ["walk.mcap", "walk.csv"].map(|name| folder.path(name));
    let said = folder.succeeds(&["convert", &golden("walk.csv.gz"), &mcap]);
    assert!(said.contains("of orientation and raw samples"), "{said}");
    let expected = detected(&folder, &golden("walk.csv.gz"));
    assert_near(detected(&folder, &mcap), expected, "mcap");

    let output = folder
        .program(&["convert", &mcap, &csv, "--json"])
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["schema"], "mlr.conversion/1");
    assert_eq!(report["has_raw_samples"], true);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("left out: covariances"), "{said}");
    assert_near(detected(&folder, &csv), expected, "csv");

    // Neither is overwritten, and what was there stays.
    let before = fs::read(&mcap).unwrap();
    folder.fails(
        &["convert", &csv, &mcap],
        2,
        &["walk.mcap", "already exists"],
    );
    assert_eq!(fs::read(&mcap).unwrap(), before);
    folder.fails(
        &["convert", &csv, &folder.path("walk.bag")],
        2,
        &["walk.bag", "bags are only read"],
    );
}

#[test]
fn what_another_format_cannot_hold_is_said() {
    let folder = Folder::new();
    let output = |arguments: &[&str]| {
        let output = folder.program(arguments).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    let bag = golden("several-topics.bag");
    let table = folder.path("of-a-bag.csv");
    let said = output(&["convert", &bag, &table, "--topic", "/imu/data_raw"]);
    assert!(said.contains("419 messages on other topics"), "{said}");
    assert!(
        said.contains("the date: times count from the first message, 1700000000.0"),
        "{said}"
    );
    let text = fs::read_to_string(&table).unwrap();
    assert!(
        text.starts_with("t_s,ax_mps2,"),
        "only raw samples: {text:.80}"
    );

    let mut early = HEADER.replace('\n', ",temperature_c\n");
    for line in standing_then_rocking(2.0, 5.0, 100.0).lines().skip(1) {
        let (time, rest) = line.split_once(',').unwrap();
        let time_s: f64 = time.parse().unwrap();
        early += &format!("{},{rest},25\n", time_s - 2.5);
    }
    let log = folder.write("early.csv", early);
    let mcap = folder.path("early.mcap");
    let said = output(&["convert", &log, &mcap]);
    assert!(
        said.contains("left out: column \"temperature_c\""),
        "{said}"
    );
    assert!(
        said.contains("times before zero: every message is 3 s later"),
        "{said}"
    );
    assert!(
        (detected(&folder, &mcap)[0] - 2.0).abs() < 0.2,
        "counted from the first message"
    );

    let late = folder.write("late.csv", format!("{HEADER}1e13,0,0,0\n1.1e13,0,0,0\n"));
    folder.fails(
        &["convert", &late, &folder.path("late.mcap")],
        2,
        &["another unit"],
    );
}
