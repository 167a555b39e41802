//! What a user gets for a log that is no log: a message that names the place,
//! the exit status that other programs rely on, and nothing on stdout.

use std::{fmt::Write as _, fs, io::Write as _};

use crate::program::{Folder, HEADER, standing_then_rocking};
use flate2::{Compression, write::GzEncoder};

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
        &["log.csv", "sampled too slowly", "45 Hz"],
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
        (
            "[simulation.contact]\nfriction = -1.0",
            "line 2: simulation.contact.friction: -1",
        ),
        ("leaders = 0", "line 1: leaders: 0"),
        (
            "[genetic]\nislands = 1000000000",
            "genetic.islands: 1000000000",
        ),
        ("[motion]\n\nwindow_s = nan", "line 3: motion.window_s: NaN"),
        (
            "[explanation.nuisance]\nclock = inf",
            "explanation.nuisance.clock: inf",
        ),
        ("[mounting]\nyaw_deg = nan", "mounting.yaw_deg: NaN"),
        (
            "[[identification.simulation.faults]]\nkind = 'weak_leg'\nleg = 9\ngain = 0.5",
            "simulation.faults[0].leg: 9",
        ),
    ] {
        let config = folder.write("mlr.toml", setting);
        for command in ["identify", "explain"] {
            folder.fails(
                &[command, &log, "--config", &config],
                BAD_INPUT,
                &[message_has, "expected"],
            );
        }
    }
}

/// Refused before the log, which is not there, is read.
#[test]
fn options_out_of_range() {
    let folder = Folder::new();
    for (arguments, message_has) in [
        (
            &["identify", "none.csv", "--window-s", "nan"][..],
            "--window-s: NaN is not valid, expected 0.5 to 600 s",
        ),
        (
            &["identify", "none.csv", "--window-s", "-5"],
            "--window-s: -5",
        ),
        (
            &["identify", "none.csv", "--window-s", "1e300"],
            "--window-s",
        ),
        (
            &["identify", "none.csv", "--from-s", "inf"],
            "--from-s: inf",
        ),
        (&["identify", "none.csv", "--from-s=-inf"], "--from-s: -inf"),
        (
            &["identify", "none.csv", "--friction", "-0.1"],
            "--friction: -0.1",
        ),
        (&["identify", "none.csv", "--repeats", "0"], "--repeats"),
        (
            &["identify", "none.csv", "--repeats", "1000000000"],
            "--repeats",
        ),
        (&["identify", "none.csv", "--seed", "-1"], "--seed"),
        (
            &["identify", "none.csv", "--seed", "18446744073709551615"],
            "--seed",
        ),
        (&["identify", "none.csv", "--threads", "0"], "--threads: 0"),
        (
            &["identify", "none.csv", "--threads", "100000"],
            "--threads: 100000 is not valid, expected 1 to ",
        ),
        (&["identify", "none.csv", "--threads", "-1"], "--threads"),
        (&["identify", "none.csv", "--config", ""], "--config"),
        (&["identify", "none.csv", "--robot", ""], "--robot"),
        (&["identify", ""], "<LOG>"),
        (
            &["explain", "none.csv", "--start-s", "nan"],
            "--start-s: NaN",
        ),
        (&["explain", "none.csv", "--seed", "-1"], "--seed"),
        (
            &["evaluate", "none", "--window-s", "nan"],
            "--window-s: NaN",
        ),
        (&["evaluate", "none", "--seed", "-1"], "--seed"),
        (
            &["simulate", "-o", "x.csv", "--stand-s", "-1"],
            "--stand-s: -1 is not valid, expected 0 to 3600 s",
        ),
        (
            &["simulate", "-o", "x.csv", "--walk-s", "0"],
            "--walk-s: 0 ",
        ),
        (
            &["simulate", "-o", "x.csv", "--time-step-s", "nan"],
            "--time-step-s: NaN",
        ),
        (
            &[
                "simulate",
                "-o",
                "x.csv",
                "--walk-s",
                "3600",
                "--time-step-s",
                "0.00001",
            ],
            "--time-step-s: 0.00001",
        ),
        (
            &["simulate", "-o", "x.csv", "--friction", "-1"],
            "--friction: -1",
        ),
        (
            &["simulate", "-o", "x.csv", "--slope-deg", "-5"],
            "--slope-deg: -5 is not valid, expected 0 to 68 degrees",
        ),
        (
            &["simulate", "-o", "x.csv", "--uphill-deg", "nan"],
            "--uphill-deg: NaN",
        ),
        (
            &["simulate", "-o", "x.csv", "--joint-friction-nm", "-0.1"],
            "--joint-friction-nm: -0.1",
        ),
        (
            &["simulate", "-o", "x.csv", "--backlash-rad", "nan"],
            "--backlash-rad: NaN",
        ),
        (
            &["simulate", "-o", "x.csv", "--rubble-m", "-0.1"],
            "--rubble-m: -0.1",
        ),
        (&["simulate", "-o", ""], "--output"),
    ] {
        folder.fails(arguments, BAD_INPUT, &[message_has]);
    }
}

#[test]
fn negative_numbers_are_arguments_of_options() {
    let folder = Folder::new();
    let log = folder.write("log.csv", standing_then_rocking(2.0, 10.0, 100.0));
    folder.fails(
        &["identify", &log, "--from-s", "-5"],
        CANNOT_ANSWER,
        &["log.csv", "from -5.00 s on"],
    );
    folder.fails(
        &["explain", "none.csv", "--start-s", "-1"],
        BAD_INPUT,
        &["none.csv", "No such file"],
    );
    let walk = folder.path("walk.csv");
    let uphill = ["--slope-deg", "5", "--uphill-deg", "-90", "--walk-s", "0.5"];
    folder.succeeds(&[&["simulate", "-o", &walk], &uphill[..]].concat());
}

#[test]
fn friction_and_play_of_the_joints_change_a_simulated_walk() {
    let folder = Folder::new();
    let walk = |name: &str, options: &[&str]| {
        let path = folder.path(name);
        let short = ["simulate", "-o", &path, "--walk-s", "2", "--legs-lost", "3"];
        folder.succeeds(&[&short, options].concat());
        fs::read_to_string(&path).unwrap()
    };
    let described = walk("described.csv", &[]);
    assert_eq!(walk("none.csv", &["--joint-friction-nm", "0"]), described);
    let sticky = walk("sticky.csv", &["--joint-friction-nm", "0.2"]);
    let loose = walk("loose.csv", &["--backlash-rad", "0.03"]);
    assert!(sticky != described && loose != described && sticky != loose);
}

#[test]
fn the_daemons_file_is_a_configuration() {
    let folder = Folder::new();
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../mlrd/systemd/mlrd.toml");
    let log = folder.write("log.csv", standing_then_rocking(2.0, 10.0, 100.0));
    let table = folder.succeeds(&["detect", &log, "--config", shipped]);
    assert!(table.contains("flagged at"), "{table}");
    let short = folder.write("short.csv", standing_then_rocking(2.0, 4.0, 100.0));
    for command in ["identify", "explain"] {
        folder.fails(
            &[command, &short, "--config", shipped],
            CANNOT_ANSWER,
            &["short.csv", "too short"],
        );
    }
    let text = fs::read_to_string(shipped).unwrap();
    let misspelt = folder.write(
        "mlrd.toml",
        text.replace("[explanation.prior]", "[explaining.prior]"),
    );
    folder.fails(
        &["detect", &log, "--config", &misspelt],
        BAD_INPUT,
        &["mlrd.toml", "`explaining`", "`explanation`", "line"],
    );
    let strict = format!("{text}\n[identification.motion]\nresponse_s = -1.0\n");
    let strict = folder.write("strict.toml", strict);
    folder.fails(
        &["detect", &log, "--config", &strict],
        BAD_INPUT,
        &[
            "strict.toml",
            "line ",
            "identification.motion.response_s: -1",
        ],
    );
}

#[test]
fn the_mounting_of_the_configuration_is_applied() {
    // The body rolls by ±3°; turned by 45°, the sensor sees ±2.1° of roll and of pitch.
    let folder = Folder::new();
    let mut text = HEADER.to_string();
    for i in 0..1000 {
        let t = f64::from(i) * 0.01;
        let roll = 3.0_f64.to_radians() * (std::f64::consts::TAU * (t - 2.0).max(0.0)).sin();
        let body = nalgebra::UnitQuaternion::from_euler_angles(roll, 0.0, 0.0);
        let body_from_sensor =
            nalgebra::UnitQuaternion::from_euler_angles(0.0, 0.0, 45.0_f64.to_radians());
        let (roll, pitch, yaw) = (body * body_from_sensor).euler_angles();
        writeln!(text, "{t:.3},{roll:.8},{pitch:.8},{yaw:.8}").unwrap();
    }
    let log = folder.write("turned.csv", text);
    let config = folder.write("mlrd.toml", "[mounting]\nyaw_deg = 45.0\n");
    let as_recorded = folder.succeeds(&["detect", &log]);
    assert!(as_recorded.contains("up to 4.1°"), "{as_recorded}");
    let mounted = folder.succeeds(&["detect", &log, "--config", &config]);
    assert!(mounted.contains("up to 5.9°"), "{mounted}");
    assert!(mounted.contains("flagged at"), "{mounted}");
}

#[test]
fn too_little_walking_to_detect_damage() {
    let folder = Folder::new();
    let detect = |name: &str, end_s: f64, times: f64| {
        let rolls = standing_then_rocking(2.0, end_s, 100.0);
        // Smaller swings than those of damage.
        let lines = rolls.lines().map(|line| match line.split_once(',') {
            Some((t, rest)) if !t.starts_with('t') => {
                let roll: f64 = rest.trim_end_matches(",0,0").parse().unwrap();
                format!("{t},{:.6},0,0\n", roll * times)
            }
            _ => format!("{line}\n"),
        });
        folder.write(name, lines.collect::<String>())
    };
    let short = detect("short.csv", 4.0, 0.2);
    folder.fails(
        &["detect", &short, "--json"],
        CANNOT_ANSWER,
        &["short.csv", "too short to tell damage", "at least 2.5 s"],
    );
    let still = detect("still.csv", 10.0, 0.0);
    folder.fails(
        &["detect", &still],
        CANNOT_ANSWER,
        &["still.csv", "no motion"],
    );
    // The controls: enough of it, and damage that was flagged in time.
    let long = folder.succeeds(&["detect", &detect("long.csv", 6.0, 0.2)]);
    assert!(long.contains("damage        none"), "{long}");
    let config = folder.write("hasty.toml", "[detector]\npersistence_s = 1.0\n");
    let flagged = detect("flagged.csv", 4.5, 1.0);
    let flagged = folder.succeeds(&["detect", &flagged, "--config", &config]);
    assert!(flagged.contains("flagged at"), "{flagged}");
}

#[test]
fn a_robot_that_cannot_stand_on_its_feet() {
    let folder = Folder::new();
    let lying = mlr_model::Gait::TRIPOD_TOML
        .replace("body_height_m = 0.090", "body_height_m = 0.005")
        .replace("lift_m = 0.040", "lift_m = 0.0");
    let lying = folder.write("lying.toml", lying);
    folder.fails(
        &["identify", "none.csv", "--gait", &lying],
        BAD_INPUT,
        &["lying.toml", "no leg reaches the ground", "body_height_m"],
    );
    let hasty = mlr_model::Gait::TRIPOD_TOML.replace("period_s = 1.0", "period_s = 0.001");
    let hasty = folder.write("hasty.toml", hasty);
    folder.fails(
        &["simulate", "-o", "x.csv", "--gait", &hasty],
        BAD_INPUT,
        &["hasty.toml", "line ", "period_s: 0.001", "0.1 to 60 s"],
    );
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
    let explanation = folder.write("explanation.toml", "most_efects = 2");
    folder.fails(
        &["explain", &log, "--explanation", &explanation],
        BAD_INPUT,
        &["explanation.toml", "most_efects", "line 1"],
    );
}
