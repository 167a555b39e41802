//! The live view: of the events of a real run, and as a program on a terminal.
//!
//! ```text
//! MLR_RECORD_GOLDEN=1 cargo test -p mlrd --test top
//! ```
//! writes the pictures anew, and
//! ```text
//! cargo test -p mlrd --test top -- --ignored
//! ```
//! the events, in some minutes.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod daemon;

use std::{
    ffi::OsStr,
    fs::{self, File, OpenOptions},
    io::{Read, Write},
    path::{Path, PathBuf},
    process::{Command, Output},
    thread,
    time::{Duration, Instant},
};

use daemon::{
    Daemon, HANG, LOG, piped,
    player::{Device, Line as SerialLine, play_in_real_time},
    signal,
};
use mlr_model::Robot;
use mlrd::{
    event::WatchedRobot,
    top::{Line, Palette, Picture, Told, View, What, draw},
};
use ratatui::{Terminal, backend::TestBackend, style::Color};
use serialport::{SerialPort, TTYPort};

fn golden(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/golden/top");
    folder.join(name)
}

/// What a daemon told that watched the robot of the log `detect-legs3-4`, explained its walk and
/// offered a gait.
fn events() -> String {
    fs::read_to_string(golden("events.jsonl")).unwrap()
}

fn view(palette: Palette) -> View {
    View {
        palette,
        silent: Duration::ZERO,
        ended: false,
        scrolled_back: 0,
    }
}

fn picture_of<'a>(lines: impl IntoIterator<Item = &'a str>) -> Picture {
    let mut picture = Picture::new(WatchedRobot::new(&Robot::jethexa()));
    for line in lines {
        picture.apply(&Line::new(line));
    }
    picture
}

fn terminal_of(picture: &Picture, view: &View, size: (u16, u16)) -> Terminal<TestBackend> {
    let mut terminal = Terminal::new(TestBackend::new(size.0, size.1)).unwrap();
    terminal.draw(|frame| draw(frame, picture, view)).unwrap();
    terminal
}

/// The picture as lines of text.
fn drawn(picture: &Picture, view: &View, size: (u16, u16)) -> String {
    let terminal = terminal_of(picture, view, size);
    let buffer = terminal.backend().buffer();
    let rows = buffer.content.chunks(size.0.into());
    let text = rows.map(|row| row.iter().map(|cell| cell.symbol()).collect::<String>());
    let lines: Vec<String> = text.map(|line| line.trim_end().to_owned() + "\n").collect();
    lines.concat()
}

/// Nothing is lost in reading: each event of the daemon is one that the view knows.
#[test]
fn every_event_of_a_real_run_is_known() {
    let events = events();
    let mut names = Vec::new();
    for text in events.lines() {
        let Line::Event(told) = Line::new(text) else {
            panic!("{text}");
        };
        let Told { name, what, .. } = *told;
        assert_ne!(what, What::Unknown, "{text}");
        names.push(name);
    }
    for name in [
        "motion_started",
        "damage_detected",
        "identified",
        "explained",
        "recovery_gait",
    ] {
        assert!(names.iter().any(|known| known == name), "{name}");
    }
}

#[test]
fn the_picture_of_a_real_run() {
    let events = events();
    let (before_its_end, stopped) = events.trim_end().rsplit_once('\n').unwrap();
    assert!(stopped.contains("\"stopped\""));
    let picture = picture_of(before_its_end.lines());
    let kept = |name: &str, size| {
        let drawn = drawn(&picture, &view(Palette::Plain), size);
        if std::env::var_os("MLR_RECORD_GOLDEN").is_some() {
            fs::write(golden(name), &drawn).unwrap();
        }
        let kept = fs::read_to_string(golden(name)).unwrap();
        assert!(
            drawn == kept,
            "{name}: this was drawn:\n{drawn}in place of:\n{kept}"
        );
        drawn
    };
    let wide = kept("wide.txt", (100, 30));
    let narrow = kept("narrow.txt", (60, 30));
    for drawn in [&wide, &narrow] {
        for expected in [
            "IDENTIFIED",
            "4 middle right",
            "threshold 5.0°",
            "recovery-1.toml",
        ] {
            assert!(drawn.contains(expected), "{expected} in\n{drawn}");
        }
    }
    let docs = include_str!("../../../docs/onboard.md");
    assert!(
        docs.contains(&wide),
        "docs/onboard.md shows another picture than\n{wide}"
    );
}

#[test]
fn damage_and_swings_have_colours_where_they_are_wanted() {
    let events = events();
    let picture = picture_of(events.lines());
    let colors = |palette| {
        let terminal = terminal_of(&picture, &view(palette), (100, 30));
        let cells = terminal.backend().buffer().content.iter();
        let mut colors: Vec<Color> = cells.map(|cell| cell.fg).collect();
        colors.sort_by_key(|color| format!("{color:?}"));
        colors.dedup();
        colors
    };
    let colored = colors(Palette::of_no_color(None));
    assert!(
        colored.contains(&Color::Red) && colored.contains(&Color::Green),
        "{colored:?}"
    );
    let plain = colors(Palette::of_no_color(Some(OsStr::new("1"))));
    assert_eq!(plain, [Color::Reset]);
}

#[test]
fn any_size_of_terminal_will_do() {
    let events = events();
    let picture = picture_of(events.lines());
    let sizes = [
        (1, 1),
        (3, 40),
        (20, 5),
        (59, 10),
        (77, 24),
        (78, 24),
        (300, 100),
    ];
    for size in sizes {
        for scrolled_back in [0, 3, 10_000] {
            let view = View {
                scrolled_back,
                ended: true,
                ..view(Palette::Colored)
            };
            drawn(&picture, &view, size);
            drawn(&picture_of([]), &view, size);
        }
    }
}

#[test]
fn the_usual_terminal_shows_everything_at_once() {
    let events = events();
    let view = View {
        ended: true,
        ..view(Palette::Plain)
    };
    let drawn = drawn(&picture_of(events.lines()), &view, (80, 24));
    for expected in [
        "STOPPED",
        "the stream has ended",
        "front left",
        "Hz",
        "no fault",
        "damage",
        "recovery",
        "stopped",
        "q leaves",
    ] {
        assert!(drawn.contains(expected), "{expected} in\n{drawn}");
    }
}

fn top(arguments: &[&str], stdin: &str) -> Output {
    let mut child = piped(&[&["top"], arguments].concat());
    // It may end without having read all.
    let _ = child.stdin.take().unwrap().write_all(stdin.as_bytes());
    child.wait_with_output().unwrap()
}

#[test]
fn without_a_terminal_each_event_is_a_line() {
    let events = events();
    let with_a_message = format!("a message of nobody\n{events}");
    let output = top(&[], &with_a_message);
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(text.lines().count(), with_a_message.lines().count());
    assert!(text.starts_with("a message of nobody\n"), "{text}");
    assert!(!text.contains('\u{1b}'), "{text}");
    for expected in [
        "ERROR  identified: legs 3 (middle left),4 (middle right) lost",
        "WARN   damage detected: roll or pitch swing by ",
        "OK     status",
    ] {
        let expected = expected.trim_end_matches("status");
        assert!(text.contains(expected), "{expected} in {text}");
    }
    let of_a_file = top(&[golden("events.jsonl").to_str().unwrap()], "");
    let of_a_file = String::from_utf8(of_a_file.stdout).unwrap();
    assert_eq!(text, format!("a message of nobody\n{of_a_file}"));
}

#[test]
fn what_is_no_stream_is_refused() {
    for (arguments, expected) in [
        (["/none-such"].as_slice(), "/none-such: No such file"),
        (&["/"], "/: is a folder, expected a file of events"),
        (&["--robot", "/none-such"], "/none-such: No such file"),
    ] {
        let output = top(arguments, "");
        assert_eq!(output.status.code(), Some(2));
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(message.contains(expected), "{message}");
    }
}

/// What the view writes on a terminal of 100 columns until it ends; `leave` is called when
/// everything is drawn.
fn on_a_terminal(leave: impl FnOnce(&mut TTYPort, u32)) -> String {
    let (mut master, terminal) = TTYPort::pair().unwrap();
    let path = terminal.name().unwrap();
    let stty = |arguments: &[&str]| {
        let output = Command::new("stty")
            .args(["-F", &path])
            .args(arguments)
            .output();
        String::from_utf8(output.unwrap().stdout).unwrap()
    };
    stty(&["sane", "cols", "100", "rows", "30"]);
    let before = stty(&["-g"]);
    let end = || -> File {
        OpenOptions::new()
            .read(true)
            .write(true)
            .open(&path)
            .unwrap()
    };
    let mut child = Command::new(env!("CARGO_BIN_EXE_mlrd"))
        .arg("top")
        .arg(golden("events.jsonl"))
        .env("TERM", "xterm-256color")
        .stdin(end())
        .stdout(end())
        .spawn()
        .unwrap();
    master.set_timeout(Duration::from_millis(100)).unwrap();
    let mut written = Vec::new();
    let (mut leave, begin) = (Some(leave), Instant::now());
    let mut bytes = [0; 4096];
    let status = loop {
        if let Ok(read) = master.read(&mut bytes) {
            written.extend_from_slice(&bytes[..read]);
            continue;
        }
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        let text = String::from_utf8_lossy(&written);
        if text.contains("ended") && leave.is_some() {
            assert_ne!(stty(&["-g"]), before, "no raw mode");
            leave.take().unwrap()(&mut master, child.id());
        }
        assert!(begin.elapsed() < HANG, "{text}");
    };
    assert!(status.success());
    assert_eq!(stty(&["-g"]), before, "the terminal is not as before");
    String::from_utf8(written).unwrap()
}

#[test]
fn the_terminal_is_restored() {
    let by_key = on_a_terminal(|master, _| master.write_all(b"q").unwrap());
    let by_signal = on_a_terminal(|_, process| signal(process, "TERM"));
    for written in [by_key, by_signal] {
        let (_, after) = written.split_once("\u{1b}[?1049h").unwrap();
        assert!(after.contains("IDENTIFIED") || after.contains("STOPPED"));
        // Nothing is left on the screen that was before, and the cursor is seen again.
        let (_, left) = after.split_once("\u{1b}[?1049l").unwrap();
        assert!(!left.contains("leaves"), "{left:?}");
        let shown = written.rfind("\u{1b}[?25h").unwrap();
        assert!(shown > written.rfind("\u{1b}[?25l").unwrap());
    }
}

/// Where the daemon of the recorded run would keep and read what it names.
const STATE_DIR: &str = "/var/lib/mlrd";
const PORT: &str = "/dev/ttyTHS1";

/// Settings with which explanation and recovery gait do little.
const LITTLE: &str = "
[explanation.effort]
bases = 1
screened = 1
entrants = 4
neighbours = 0
extended = 0
most_effects = 1
[recovery]
screen_steps = 1
robots = 2
judged_robots = 4
generations = 2
";

#[test]
#[ignore = "records the events of a run anew, in some minutes"]
fn a_run_is_recorded_anew() {
    let folder = tempfile::tempdir().unwrap();
    let (port, state) = (folder.path().join("imu"), folder.path().join("state"));
    let config = folder.path().join("mlrd.toml");
    fs::write(&config, format!("status_every_s = 5.0\n{LITTLE}")).unwrap();
    let [port_name, state_name] = [&port, &state].map(|path| path.to_str().unwrap());
    let daemon = Daemon::start([
        "--port",
        port_name,
        "--state-dir",
        state_name,
        "--config",
        config.to_str().unwrap(),
    ]);
    let mut told = daemon.told_until(|event| event["event"] == "port_lost");
    let line = SerialLine::plugged_in(&port);
    let frames = Device::RegisterBurst.frames(LOG);
    let player = thread::spawn(move || play_in_real_time(line, &frames, false));
    told.extend(daemon.told_until(|event| event["event"] == "explained"));
    told.extend(daemon.told_until(|event| event["event"] == "recovery_gait"));
    told.extend(daemon.told_until(|event| event["event"] == "status"));
    let _line = player.join().unwrap();
    told.extend(daemon.terminate());
    // While explanation and gait are worked out the line is silent, which says nothing new.
    let mut good = serde_json::Value::Null;
    told.retain(|event| {
        event["event"] != "status" || {
            let before = std::mem::replace(&mut good, event["good"].clone());
            before != good
        }
    });
    let lines = told.iter().map(|event| format!("{event}\n"));
    let text = lines.collect::<String>();
    let text = text.replace(port_name, PORT).replace(state_name, STATE_DIR);
    fs::create_dir_all(golden("")).unwrap();
    fs::write(golden("events.jsonl"), text).unwrap();
}
