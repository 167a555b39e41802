//! What a user gets for a log that is no log: a message that names the place,
//! the exit status that other programs rely on, and nothing on stdout.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod program;

use std::{fmt::Write as _, fs, io::Write as _};

use flate2::{Compression, write::GzEncoder};
use program::{Folder, HEADER, standing_then_rocking};

/// Exit status: the log was read and cannot answer.
const CANNOT_ANSWER: i32 = 1;
/// Exit status: wrong usage or unreadable input.
const BAD_INPUT: i32 = 2;

/// Runs `identify` on a file of this content and checks how it fails.
fn refused(content: impl AsRef<[u8]>, status: i32, message_has: &[&str]) {
    let folder = Folder::new();
    let log = folder.write("log.csv", content);
    folder.fails(&["identify", "--json", &log], status, message_has);
}

#[test]
fn empty_file() {
    refused("", BAD_INPUT, &["log.csv", "is empty", "header"]);
}

#[test]
fn header_only() {
    refused(HEADER, BAD_INPUT, &["log.csv", "no samples"]);
}

#[test]
fn missing_column() {
    refused(
        "t_s,roll_rad,yaw_rad\n0,0,0\n",
        BAD_INPUT,
        &[
            "log.csv",
            "line 1",
            "\"pitch_rad\"",
            "t_s, roll_rad, yaw_rad",
        ],
    );
}

#[test]
fn text_in_a_number() {
    refused(
        format!("{HEADER}0,0,0,0\n0.1,0,fast,0\n"),
        BAD_INPUT,
        &["log.csv", "line 3", "\"pitch_rad\"", "\"fast\""],
    );
}

#[test]
fn not_a_number() {
    refused(
        format!("{HEADER}0,0,0,0\n0.1,0,0,NaN\n"),
        BAD_INPUT,
        &["log.csv", "line 3", "\"yaw_rad\"", "\"NaN\""],
    );
}

#[test]
fn two_samples() {
    refused(
        format!("{HEADER}0,0,0,0\n0.001,0.1,0,0\n"),
        CANNOT_ANSWER,
        &["log.csv", "no motion"],
    );
}

#[test]
fn no_motion() {
    let mut text = HEADER.to_string();
    for i in 0..8000 {
        let noise = f64::from((i * 7919) % 101) * 1e-6;
        writeln!(text, "{},{noise},0.01,0", f64::from(i) * 0.001).unwrap();
    }
    refused(text, CANNOT_ANSWER, &["log.csv", "no motion"]);
}

#[test]
fn too_short_after_the_start() {
    refused(
        standing_then_rocking(2.0, 5.0, 970.0),
        CANNOT_ANSWER,
        &["log.csv", "too short", "5.00 s"],
    );
}

#[test]
fn sampled_too_slowly() {
    refused(
        standing_then_rocking(2.0, 10.0, 30.0),
        CANNOT_ANSWER,
        &["log.csv", "sampled too slowly", "50 Hz"],
    );
}

#[test]
fn sampled_too_slowly_for_the_detector() {
    let folder = Folder::new();
    let log = folder.write("slow.csv", standing_then_rocking(2.0, 10.0, 4.8));
    folder.fails(
        &["detect", &log, "--json"],
        CANNOT_ANSWER,
        &["slow.csv", "sampled too slowly: 4.8 Hz", "at least 20 Hz"],
    );
}

#[test]
fn samples_missing() {
    let text: String = standing_then_rocking(2.0, 10.0, 970.0)
        .lines()
        .enumerate()
        .filter(|(line, _)| !(3000..3600).contains(line))
        .map(|(_, text)| format!("{text}\n"))
        .collect();
    refused(
        text,
        CANNOT_ANSWER,
        &["log.csv", "samples are missing from 3.0"],
    );
}

#[test]
fn time_running_backwards() {
    let forwards = standing_then_rocking(2.0, 10.0, 970.0);
    let mut lines: Vec<&str> = forwards.lines().collect();
    lines[1..].reverse();
    refused(
        lines.join("\n"),
        CANNOT_ANSWER,
        &["log.csv", "time does not run forward", "sample 2"],
    );
}

#[test]
fn truncated_gzip() {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder
        .write_all(standing_then_rocking(2.0, 10.0, 970.0).as_bytes())
        .unwrap();
    let whole = encoder.finish().unwrap();
    refused(
        &whole[..whole.len() / 2],
        BAD_INPUT,
        &["log.csv", "line ", "gzip"],
    );
}

#[test]
fn directory() {
    let folder = Folder::new();
    let path = folder.path("");
    folder.fails(&["identify", &path], BAD_INPUT, &["is a directory"]);
}

#[test]
fn file_that_is_not_there() {
    let folder = Folder::new();
    let path = folder.path("none.csv");
    folder.fails(
        &["identify", &path],
        BAD_INPUT,
        &["none.csv", "No such file"],
    );
}

/// A file that exists and opens, but fails when it is read, whoever reads it.
#[cfg(target_os = "linux")]
#[test]
fn unreadable_file() {
    let folder = Folder::new();
    let path = folder.path("memory.csv");
    std::os::unix::fs::symlink("/proc/self/mem", &path).unwrap();
    folder.fails(&["identify", &path], BAD_INPUT, &["memory.csv", "error"]);
}

#[test]
fn misspelt_setting() {
    let folder = Folder::new();
    let log = folder.write("log.csv", standing_then_rocking(2.0, 10.0, 100.0));
    let config = folder.write("mlr.toml", "[genetic]\ngeneration = 3\n");
    folder.fails(
        &["identify", &log, "--config", &config],
        BAD_INPUT,
        &["mlr.toml", "line 2", "`generation`", "`generations`"],
    );
}

#[test]
fn settings_out_of_range() {
    let folder = Folder::new();
    let log = folder.write("log.csv", standing_then_rocking(2.0, 10.0, 100.0));
    for (setting, message_has) in [
        ("window_s = -1.0", "window_s: -1"),
        ("[genetic]\npopulation = 1", "genetic.population: 1"),
        (
            "[genetic]\nmutation_rate = 1.5",
            "genetic.mutation_rate: 1.5",
        ),
        ("[filter]\ncutoff_hz = 0.0", "filter.cutoff_hz: 0"),
        (
            "[simulation]\ntime_step_s = 0.5",
            "simulation.time_step_s: 0.5",
        ),
        ("[simulation.contact]\nfriction = -1.0", "friction: -1"),
    ] {
        let config = folder.write("mlr.toml", setting);
        folder.fails(
            &["identify", &log, "--config", &config],
            BAD_INPUT,
            &[message_has, "expected"],
        );
    }
}

#[test]
fn robot_and_gait_that_do_not_fit() {
    let folder = Folder::new();
    let log = folder.write("log.csv", standing_then_rocking(2.0, 10.0, 100.0));
    let tripod = mlr_model::Gait::TRIPOD_TOML;
    for (name, gait, message_has) in [
        (
            "long.toml",
            tripod.replace("0.060", "0.5"),
            vec!["leg 2 cannot reach", "gait time"],
        ),
        (
            "few.toml",
            tripod.replace(", 0.5]", "]"),
            vec!["5 phase offsets", "6 legs"],
        ),
        (
            "typo.toml",
            tripod.replace("lift_m", "lft_m"),
            vec!["typo.toml", "lft_m", "line"],
        ),
    ] {
        let gait = folder.write(name, gait);
        folder.fails(
            &["identify", &log, "--gait", &gait],
            BAD_INPUT,
            &message_has,
        );
    }
    let robot = mlr_model::Robot::JETHEXA_TOML.replace("mass_kg = 1.369", "mass_kg = -1.0");
    let robot = folder.write("robot.toml", robot);
    folder.fails(
        &["identify", &log, "--robot", &robot],
        BAD_INPUT,
        &["robot.toml", "body.mass_kg: -1", "expected a mass"],
    );
}

#[test]
fn wrong_usage() {
    let folder = Folder::new();
    folder.fails(&["identify"], BAD_INPUT, &["LOG"]);
    folder.fails(
        &["identify", "x.csv", "--search", "magic"],
        BAD_INPUT,
        &["ga, exact"],
    );
    folder.fails(
        &["identify", "x.csv", "--column", "roll"],
        BAD_INPUT,
        &["--column", "QUANTITY=NAME"],
    );
}

#[test]
fn a_log_is_never_overwritten() {
    let folder = Folder::new();
    let log = folder.write("mine.csv", "precious");
    folder.fails(
        &["simulate", "-o", &log],
        BAD_INPUT,
        &["mine.csv", "not overwritten"],
    );
    assert_eq!(fs::read_to_string(&log).unwrap(), "precious");
}

#[test]
fn what_cannot_be_explained() {
    let folder = Folder::new();
    let log = folder.write("short.csv", standing_then_rocking(2.0, 4.0, 100.0));
    folder.fails(
        &["explain", &log],
        CANNOT_ANSWER,
        &["short.csv", "too short", "needed"],
    );
    let report = folder.write("report.json", "precious");
    folder.fails(
        &["explain", &log, "-o", &report],
        BAD_INPUT,
        &["report.json", "not overwritten"],
    );
    assert_eq!(fs::read_to_string(&report).unwrap(), "precious");
    let tracing = folder.write("tracing.toml", "most_efects = 2");
    folder.fails(
        &["explain", &log, "--tracing", &tracing],
        BAD_INPUT,
        &["tracing.toml", "most_efects", "line 1"],
    );
}
