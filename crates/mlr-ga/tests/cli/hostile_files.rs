//! Files that are made to harm: they end with a short message, in bounded memory.
#![cfg(target_os = "linux")]

use std::{
    fs::{self, File},
    io::{BufWriter, Write},
    process::{Command, Output},
};

use crate::program::{Folder, HEADER, standing_then_rocking};
use assert_cmd::cargo::cargo_bin;
use flate2::{Compression, write::GzEncoder};

/// Address space that the program gets, in kB: more than it ever holds in memory.
const MEMORY_KB: u32 = 300 * 1024;

/// Runs the program in a shell after a limit was set.
fn limited(limit: &str, arguments: &[&str]) -> Output {
    let mut shell = Command::new("sh");
    shell
        .args(["-c", &format!("ulimit {limit}; exec \"$@\""), "sh"])
        .arg(cargo_bin("mlr-ga"))
        .args(arguments);
    shell.output().unwrap()
}

/// The program must refuse this in bounded memory, with a short message that has all of this.
fn refused(arguments: &[&str], message_has: &[&str]) {
    let mut arguments = arguments.to_vec();
    arguments.extend(["--threads", "1"]);
    let output = limited(&format!("-v {MEMORY_KB}"), &arguments);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(output.stdout.is_empty(), "no partial result");
    assert!(message.chars().count() < 2100, "{message}");
    assert!(
        message.chars().all(|c| c == '\n' || !c.is_control()),
        "{message:?}"
    );
    assert!(!message.contains("line 0"), "{message}");
    for part in message_has {
        assert!(message.contains(part), "{part:?} is not in: {message}");
    }
}

/// A gzip file of a beginning and a block that is repeated: compressed once, as members one
/// behind the other.
fn repeated_gzip(folder: &Folder, name: &str, begin: &str, block: &[u8], times: usize) -> String {
    let path = folder.path(name);
    let zip = |content: &[u8]| {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
        encoder.write_all(content).unwrap();
        encoder.finish().unwrap()
    };
    let mut file = BufWriter::new(File::create(&path).unwrap());
    file.write_all(&zip(begin.as_bytes())).unwrap();
    let member = zip(block);
    for _ in 0..times {
        file.write_all(&member).unwrap();
    }
    file.flush().unwrap();
    path
}

#[test]
fn a_line_of_a_gigabyte() {
    let folder = Folder::new();
    let log = repeated_gzip(&folder, "line.csv.gz", HEADER, &[b'0'; 10_000_000], 100);
    refused(
        &["identify", &log],
        &["line.csv.gz: line 2: is longer than 1000000 bytes"],
    );
    let header = repeated_gzip(&folder, "header.csv.gz", "t_s", &[b'0'; 10_000_000], 100);
    refused(&["detect", &header], &["line 1: is longer"]);
}

#[test]
fn a_hundred_million_columns() {
    let folder = Folder::new();
    let block = b"a,".repeat(5_000_000);
    let log = repeated_gzip(&folder, "columns.csv.gz", "", &block, 20);
    refused(&["identify", &log], &["columns.csv.gz", "line 1"]);
    let log = folder.write("many.csv", b"a,".repeat(20_000));
    refused(&["identify", &log], &["more than 1000 columns"]);
}

#[test]
fn twenty_six_million_rows() {
    let folder = Folder::new();
    let header = "t_s,roll_rad,pitch_rad,yaw_rad,\
                  ax_mps2,ay_mps2,az_mps2,gx_radps,gy_radps,gz_radps\n";
    let block = b"1,0,0,0,0,0,9.8,0,0,0\n".repeat(260_000);
    let log = repeated_gzip(&folder, "rows.csv.gz", header, &block, 100);
    refused(
        &["identify", &log],
        &[
            "rows.csv.gz: line 1000002: has more than 1000000 rows",
            "--max-rows",
        ],
    );
    refused(
        &["identify", &log, "--max-rows", "5000"],
        &["line 5002: has more than 5000 rows"],
    );
    // Text that holds no rows ends, too.
    let comments = b"# nothing to see here, and nowhere else\n".repeat(250_000);
    let log = repeated_gzip(&folder, "comments.csv.gz", HEADER, &comments, 100);
    refused(&["detect", &log], &["more than 512 MB of text"]);
}

#[test]
fn files_without_an_end() {
    let folder = Folder::new();
    let log = folder.write("log.csv", standing_then_rocking(2.0, 10.0, 100.0));
    for device in ["/dev/zero", "/dev/urandom"] {
        refused(
            &["identify", &log, "--atlas", device],
            &[device, "is no atlas"],
        );
        for option in ["--robot", "--gait", "--config"] {
            refused(
                &["identify", &log, option, device],
                &[device, "is larger than"],
            );
        }
        refused(
            &["explain", &log, "--explanation", device],
            &[device, "is larger than"],
        );
        refused(&["identify", device], &[device, "line 1"]);
        fs::create_dir_all(folder.path(&format!("of{device}"))).unwrap();
        let directory = folder.path(&format!("of{device}"));
        std::os::unix::fs::symlink(device, format!("{directory}/truth.json")).unwrap();
        refused(&["evaluate", &directory], &["truth.json", "is larger than"]);
        refused(
            &[
                "explain-sensor",
                &log,
                "--rate",
                "r",
                "--angle",
                "a",
                "--apply",
                device,
            ],
            &[device, "is larger than"],
        );
    }
}

#[test]
fn an_atlas_that_promises_too_much() {
    let folder = Folder::new();
    let log = folder.write("log.csv", standing_then_rocking(2.0, 10.0, 100.0));
    let begin = |header_length: u32| {
        let mut bytes = b"MLRATLAS".to_vec();
        bytes.extend(1_u32.to_le_bytes());
        bytes.extend(header_length.to_le_bytes());
        bytes
    };
    let atlas = folder.write("length.atlas", begin(u32::MAX));
    refused(&["identify", &log, "--atlas", &atlas], &["length.atlas"]);
    let atlas = folder.write("short.atlas", begin(1000));
    refused(&["identify", &log, "--atlas", &atlas], &["is truncated"]);
}

#[test]
fn what_a_file_says_does_not_reach_the_terminal_as_it_is() {
    let folder = Folder::new();
    let names = "\u{1b}[2J\u{202e}lor\u{7f},".repeat(900);
    let log = folder.write("log.csv", format!("{names}\n0\n"));
    refused(&["identify", &log], &["no column \"t_s\"", "more)"]);
    let text = format!("{HEADER}0,0,\u{1b}]0;owned\u{7}\u{202e},0\n");
    let log = folder.write("row.csv", text);
    refused(&["identify", &log], &["line 2", "pitch_rad"]);
    let config = folder.write(
        "c.toml",
        format!("a = \"\u{9b}\u{202e}{}\"\n", "x".repeat(900_000)),
    );
    refused(
        &["identify", &log, "--config", &config],
        &["c.toml", "line 1", "unknown field `a`"],
    );
    let output = limited(
        "-v 307200",
        &["identify", &log, "--robot", &config, "--threads", "1"],
    );
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(!message.contains(['\u{202e}', '\u{9b}']), "{message:?}");
}

#[test]
fn nothing_is_left_of_a_file_that_may_not_grow() {
    let folder = Folder::new();
    for name in ["walk.csv", "walk.csv.gz"] {
        let output = limited("-f 8", &["simulate", "-o", &folder.path(name)]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(
            message.contains(name) && message.contains("too large"),
            "{message}"
        );
        assert_eq!(fs::read_dir(folder.path("")).unwrap().count(), 0);
    }
    // With enough room the same file appears.
    let output = limited("-f 8000", &["simulate", "-o", &folder.path("walk.csv")]);
    assert!(output.status.success());
    assert_eq!(fs::read_dir(folder.path("")).unwrap().count(), 1);
}
