//! Logs as other programs write them: each is read to the numbers of the plain one.

use std::{
    f64::consts::{PI, TAU},
    io::Write as _,
};

use crate::program::Folder;
use flate2::{Compression, write::GzEncoder};
use nalgebra::UnitQuaternion;
use serde_json::Value;

/// A row of the plain log: time, roll, pitch, yaw.
type Row = [f64; 4];

/// A body that stands for two seconds, then rocks and turns by more than a turn.
fn rows() -> Vec<Row> {
    (0..1000)
        .map(|i| {
            let time_s = f64::from(i) * 0.01;
            let moving_s = (time_s - 2.0).max(0.0);
            // No sensor says the same twice.
            let noise = |axis: i32| f64::from((i * 7919 + axis * 104_729) % 1009 - 504) * 2e-7;
            let roll = 0.2 * (TAU * moving_s).sin() + noise(1);
            let pitch = 0.05 * (2.0 * TAU * moving_s).sin() - 0.01 + noise(2);
            [time_s, roll, pitch, 2.5 + 0.9 * moving_s + noise(3)]
        })
        .collect()
}

fn table(header: &str, separator: &str, row: impl Fn(&Row) -> Vec<String>) -> String {
    let mut text = format!("{header}\n");
    for values in rows() {
        text += &row(&values).join(separator);
        text += "\n";
    }
    text
}

fn numbers(row: &Row) -> Vec<String> {
    row.iter().map(|x| format!("{x:.9}")).collect()
}

fn plain() -> String {
    table("t_s,roll_rad,pitch_rad,yaw_rad", ",", numbers)
}

fn with_commas(row: &Row) -> Vec<String> {
    let numbers = numbers(row).into_iter();
    numbers.map(|text| text.replace('.', ",")).collect()
}

fn detected(folder: &Folder, log: &str, more: &[&str], stdin: &[u8]) -> Value {
    let mut arguments = vec!["detect", log, "--json"];
    arguments.extend(more);
    let mut program = folder.program(&arguments);
    let output = program.write_stdin(stdin).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{message}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The log is detected in like the plain one, with a warning that has this in it, if any.
fn read_like_plain(content: impl AsRef<[u8]>, more: &[&str], warning: Option<&str>) {
    let folder = Folder::new();
    let expected = detected(&folder, &folder.write("plain.csv", plain()), &[], b"");
    assert_eq!(expected["flagged"], true, "the body rocks");
    let found = detected(&folder, &folder.write("foreign", content), more, b"");
    same(&found, &expected);
    let warnings = found["warnings"].as_array().unwrap();
    match warning {
        None => assert!(warnings.is_empty(), "{warnings:?}"),
        Some(part) => assert!(
            warnings.iter().any(|w| w.as_str().unwrap().contains(part)),
            "{warnings:?}"
        ),
    }
}

fn same(found: &Value, expected: &Value) {
    for field in ["motion_start_s", "damage_s", "max_fluctuation_deg"] {
        let (ours, theirs) = (&found[field], &expected[field]);
        let apart = ours.as_f64().unwrap() - theirs.as_f64().unwrap();
        assert!(apart.abs() < 1e-5, "{field}: {ours}, plain {theirs}");
    }
}

#[test]
fn every_delimiter() {
    for (separator, header) in [
        (";", "t_s;roll_rad;pitch_rad;yaw_rad"),
        ("\t", "t_s\troll_rad\tpitch_rad\tyaw_rad"),
        ("   ", "  t_s  roll_rad   pitch_rad  yaw_rad"),
        (" , ", "\"T_s\", \"Roll_RAD\" ,pitch_rad, 'yaw_rad'"),
    ] {
        read_like_plain(table(header, separator, numbers), &[], None);
    }
}

#[test]
fn decimal_commas_are_told() {
    for separator in [";", "\t", "  "] {
        let header = ["t_s", "roll_rad", "pitch_rad", "yaw_rad"].join(separator);
        let text = table(&header, separator, with_commas);
        read_like_plain(text, &[], Some("decimal comma"));
    }
}

#[test]
fn commas_that_may_be_thousands_are_refused() {
    let folder = Folder::new();
    let text = "t_s;roll_rad;pitch_rad;yaw_rad\n0;1,234;0;0\n1;1,235;0;0\n";
    folder.fails(
        &["detect", &folder.write("log.csv", text)],
        2,
        &["line 2", "roll_rad", "1,234", "thousands"],
    );
}

#[test]
fn quaternions_and_turned_signs() {
    let quaternion = |row: &Row| {
        let [time, roll, pitch, yaw] = *row;
        let q = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
        // Either sign is the same rotation.
        let sign = if time < 3.0 { 1.0 } else { -1.0 };
        let [x, y, z, w] = [q.i, q.j, q.k, q.w].map(|x| format!("{:.12}", sign * x));
        vec![format!("{time}"), w, x, y, z]
    };
    read_like_plain(table("t_s,qw,qx,qy,qz", ",", quaternion), &[], None);
    let foreign = table("t_s,o.w,o.x,o.y,o.z", ",", quaternion);
    let mapping = ["qw=o.w", "qx=o.x", "qy=o.y", "qz=o.z"].map(|m| format!("--column={m}"));
    read_like_plain(foreign, &mapping.each_ref().map(String::as_str), None);

    // x forward, y right, z down.
    let turned = |row: &Row| numbers(&[row[0], row[1], -row[2], -row[3]]);
    let text = table("t_s,roll_rad,pitch_rad,yaw_rad", ",", turned);
    read_like_plain(
        text,
        &["--column=pitch=-pitch_rad", "--column=yaw=-yaw_rad"],
        None,
    );
}

#[test]
fn a_quaternion_that_is_no_rotation_names_its_line() {
    let folder = Folder::new();
    let log = folder.write("log.csv", "t_s,qw,qx,qy,qz\n0,1,0,0,0\n1,1,0.5,0,0\n");
    folder.fails(
        &["detect", &log],
        2,
        &["log.csv", "line 3", "qw, qx, qy, qz", "norm 1.118"],
    );
}

#[test]
fn angles_that_jump_by_a_turn() {
    for low in [-PI, 0.0] {
        let wrapped = |row: &Row| {
            let wrap = |angle: f64| (angle - low).rem_euclid(TAU) + low;
            numbers(&[row[0], wrap(row[1]), wrap(row[2]), wrap(row[3])])
        };
        let text = table("t_s,roll_rad,pitch_rad,yaw_rad", ",", wrapped);
        assert_ne!(text, plain());
        read_like_plain(text, &[], None);
        let degrees = |row: &Row| {
            let wrap = |angle: f64| ((angle - low).rem_euclid(TAU) + low).to_degrees();
            numbers(&[row[0], wrap(row[1]), wrap(row[2]), wrap(row[3])])
        };
        read_like_plain(
            table("t_s,r,p,y", ",", degrees),
            &[
                "--column=roll=r,deg",
                "--column=pitch=p,deg",
                "--column=yaw=y,deg",
            ],
            None,
        );
    }
}

#[test]
fn dates_count_from_the_first() {
    for (separator, zone) in [("T", "Z"), (" ", ""), ("T", "+02:00"), (" ", "Z")] {
        let dated = |row: &Row| {
            let mut fields = numbers(row);
            let seconds = 55.0 + row[0];
            let (minute, second) = (59 + (seconds / 60.0) as u32, seconds % 60.0);
            let (hour, minute) = (23 + minute / 60, minute % 60);
            let (day, hour) = (31 + hour / 24, hour % 24);
            let day = if day > 31 { "2026-01-01" } else { "2025-12-31" };
            fields[0] = format!("{day}{separator}{hour:02}:{minute:02}:{second:06.3}{zone}");
            fields
        };
        let text = table("t_s,roll_rad,pitch_rad,yaw_rad", ",", dated);
        assert!(text.contains("2026-01-01") && text.contains("2025-12-31"));
        read_like_plain(text, &[], None);
    }
}

#[test]
fn single_bad_rows_and_a_cut_end_are_left_out_and_told() {
    let mut lines: Vec<String> = plain().lines().map(String::from).collect();
    lines[50] = "0.49,oops,0,0".into();
    lines[80] = "0.79,0.1".into();
    lines[120] = "1.19,NaN,0,0".into();
    lines.push("10.0,0.1,0.01".into());
    let text = lines.join("\n");
    read_like_plain(&text, &[], Some("3 of 1000 rows cannot be read"));
    read_like_plain(&text, &[], Some("line 1002: the last row is cut off"));
    // Cut within its last number, which then looks like one.
    let cut = format!("{}10.0,0.100000000,0.010000000,9.", plain());
    read_like_plain(cut, &[], Some("cut off"));
    // A last row that is whole needs no line end.
    read_like_plain(plain().trim_end(), &[], None);

    let mut latin = plain().into_bytes();
    latin.extend(b"10.0,0.1,\xb0,0\n");
    read_like_plain(latin, &[], Some("line 1002: is not UTF-8 text"));
}

#[test]
fn many_bad_rows_are_refused_with_the_first() {
    let folder = Folder::new();
    let mut lines: Vec<String> = plain().lines().map(String::from).collect();
    for line in &mut lines[100..106] {
        *line = "broken".into();
    }
    let log = folder.write("row.csv", lines.join("\n"));
    folder.fails(&["detect", &log], 2, &["row.csv", "line 101", "1 fields"]);
    let mut lines: Vec<String> = plain().lines().map(String::from).collect();
    for line in lines.iter_mut().skip(100).step_by(50) {
        *line = "1,fast,0,0".into();
    }
    let log = folder.write("share.csv", lines.join("\n"));
    folder.fails(&["detect", &log], 2, &["line 101", "roll_rad", "fast"]);
}

#[test]
fn standard_input_is_read_plain_and_gzipped() {
    let folder = Folder::new();
    let expected = detected(&folder, &folder.write("plain.csv", plain()), &[], b"");
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(plain().as_bytes()).unwrap();
    for content in [plain().into_bytes(), encoder.finish().unwrap()] {
        let found = detected(&folder, "-", &[], &content);
        assert_eq!(found["log"], "-");
        same(&found, &expected);
    }
    for command in ["identify", "explain", "detect"] {
        let output = folder
            .program(&[command, "-"])
            .write_stdin("t_s\n")
            .output();
        let output = output.unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains("-: line 1: no column"), "{message}");
    }
    let arguments = ["explain-sensor", "-", "--rate", "gx_dps", "--angle", "a"];
    let output = folder
        .program(&arguments)
        .write_stdin("t_s,gx_dsp\n")
        .output();
    let message = String::from_utf8(output.unwrap().stderr).unwrap();
    assert!(
        message.contains("-: line 1: no column \"gx_dps\"") && message.contains("near it: gx_dsp"),
        "{message}"
    );
}

#[test]
fn a_missing_column_says_what_to_type() {
    let folder = Folder::new();
    let header = "time_ms,roll_deg,Pitch [deg],imu.yaw";
    let degrees = |row: &Row| {
        let [time, roll, pitch, yaw] = *row;
        numbers(&[time * 1e3, roll.to_degrees(), pitch.to_degrees(), yaw])
    };
    let text = table(header, ",", degrees);
    let log = folder.write("log.csv", &text);
    folder.fails(
        &["identify", &log],
        2,
        &[
            "line 1: no column \"t_s\"",
            "--column t=time_ms,ms --column roll=roll_deg,deg",
            "--column 'pitch=Pitch [deg],deg' --column yaw=imu.yaw",
        ],
    );
    // What it says is what is needed.
    let mapping = [
        "--column=t=time_ms,ms",
        "--column=roll=roll_deg,deg",
        "--column=pitch=Pitch [deg],deg",
        "--column=yaw=imu.yaw",
    ];
    read_like_plain(text, &mapping, None);
}

#[test]
fn a_simulated_log_goes_through_a_pipe() {
    let folder = Folder::new();
    let text = folder.succeeds(&["simulate", "-o", "-", "--walk-s", "1", "--stand-s", "1"]);
    assert!(
        text.starts_with("t_s,roll_rad,pitch_rad,yaw_rad\n"),
        "{text}"
    );
    let file = folder.path("same.csv");
    folder.succeeds(&["simulate", "-o", &file, "--walk-s", "1", "--stand-s", "1"]);
    assert_eq!(text, std::fs::read_to_string(&file).unwrap());
    for arguments in [
        vec!["explain", "-", "-o", "-"],
        vec!["identify", "-", "--plot", "-"],
        vec!["atlas", "build", "-o", "-"],
    ] {
        folder.fails(&arguments, 2, &["expected the name of a file"]);
    }
}
