//! From damage to its explanation, on a real pseudo-terminal. Time is the device's, as
//! fast as the daemon reads. An explanation takes minutes, and is waited for only on
//! demand:
//!
//! ```text
//! cargo test --release -p mlrd --test onboard -- explanation --ignored --nocapture
//! ```
#![allow(clippy::print_stdout, reason = "what was measured is shown")]

use std::{
    fs, thread,
    time::{Duration, Instant},
};

use crate::daemon::{
    Daemon, HANG, LOG, QUICK,
    player::{Device, Line},
};

/// What the damaged walk shows by then is enough for an identification, and too little
/// for an explanation.
const IDENTIFIED_BY_S: f64 = 28.0;
/// What is left of the log is sent so slowly that the explanation has begun by the end.
const PIECE: Duration = Duration::from_millis(1);
/// What a thread of the lowest priority has.
const NICEST: &str = "19";

/// Status without a new sample after which no more of them will come: a minute, as the
/// daemon counts it.
const STATUS_OF_SILENCE: usize = 120;

/// A daemon that has identified the robot of the log, and heard all of the log.
struct Story {
    daemon: Daemon,
    sent: usize,
    /// How long this computer took to identify it.
    identified_in: Duration,
    _line: Line,
    _folder: tempfile::TempDir,
}

impl Story {
    fn told(settings: &str, more: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let config = folder.path().join("mlrd.toml");
        fs::write(&config, format!("status_every_s = 0.5\n{settings}")).unwrap();
        let port = folder.path().join("imu");
        let arguments = ["--port", port.to_str().unwrap(), "--config"];
        let arguments = arguments.into_iter().chain([config.to_str().unwrap()]);
        let daemon = Daemon::start(arguments.chain(more.iter().copied()));
        daemon.next("port_lost");
        let mut line = Line::plugged_in(&port);
        daemon.next("port_opened");
        let frames = Device::RegisterBurst.frames(LOG);
        let (before, after) =
            frames.split_at(frames.partition_point(|frame| frame.time_s < IDENTIFIED_BY_S));
        for frame in before {
            line.send(&frame.bytes);
        }
        let begin = Instant::now();
        let identified = daemon.next("identified");
        let identified_in = begin.elapsed();
        println!(
            "{} identified in {:.1} s",
            identified["result"]["description"],
            identified_in.as_secs_f64()
        );
        for frame in after {
            line.send(&frame.bytes);
            thread::sleep(PIECE);
        }
        Self {
            daemon,
            sent: frames.len(),
            identified_in,
            _line: line,
            _folder: folder,
        }
    }

    /// No frame was lost, whatever the daemon was busy with.
    fn expect_every_frame(&self) {
        let (mut good, mut silent) = (0, 0);
        while good < self.sent {
            let status = self.daemon.next("status");
            assert_eq!((&status["bad"], &status["lost"]), (&0.into(), &0.into()));
            let before = good;
            good = usize::try_from(status["good"].as_u64().unwrap()).unwrap();
            silent = if good > before { 0 } else { silent + 1 };
            assert!(silent < STATUS_OF_SILENCE, "{status} of {}", self.sent);
        }
        assert_eq!(good, self.sent);
    }
}

/// Niceness and time of processor, in hundredths of a second, of the thread that
/// explains.
fn explaining_thread(process: u32) -> (String, u64) {
    let stats = fs::read_dir(format!("/proc/{process}/task")).unwrap();
    let stat = stats
        .map(|task| fs::read_to_string(task.unwrap().path().join("stat")).unwrap())
        .find(|stat| stat.contains("(explain-0)"))
        .unwrap();
    // Fields 14 and 19 of proc(5).
    let fields = crate::daemon::stat_fields(&stat);
    (fields[16].into(), fields[11].parse().unwrap())
}

#[test]
fn an_explanation_delays_neither_the_reading_nor_the_end() {
    let story = Story::told(QUICK, &["--threads", "2"]);
    let process = story.daemon.id();
    let begin = Instant::now();
    loop {
        let (niceness, busy) = explaining_thread(process);
        assert_eq!(niceness, NICEST);
        if busy > 0 {
            break;
        }
        assert!(begin.elapsed() < HANG, "nothing is explained");
        thread::sleep(Duration::from_millis(100));
    }
    story.expect_every_frame();
    let (begin, identified_in) = (Instant::now(), story.identified_in);
    let told = story.daemon.terminate();
    let ended_in = begin.elapsed();
    assert!(told.iter().all(|event| event["event"] != "explained"));
    // An explanation takes many times as long as the identification before it.
    assert!(ended_in < identified_in, "{ended_in:?} {identified_in:?}");
}

#[test]
#[ignore = "takes minutes, even in release"]
fn an_identified_walk_is_explained() {
    let story = Story::told("", &[]);
    let begin = Instant::now();
    let explained = story.daemon.next("explained");
    println!(
        "explained in {:.1} s: {}",
        begin.elapsed().as_secs_f64(),
        explained["result"]["effects"]
    );
    let result = &explained["result"];
    assert_eq!(result["schema"], "mlr.explanation/1");
    assert_eq!(result["seed"], 1);
    assert!(result["log"].as_str().unwrap().ends_with("imu"));
    let unseen_s = &result["stretches_s"]["validation"];
    let length_s = unseen_s[1].as_f64().unwrap() - unseen_s[0].as_f64().unwrap();
    assert!((3.0..6.0).contains(&length_s), "{unseen_s}");
    assert_eq!(result["damaged_legs"], serde_json::json!([3, 4]));
    let probability = result["effect_probability"].as_object().unwrap();
    let of = |kind: &str| probability[kind].as_f64().unwrap();
    for (kind, share) in probability {
        let share = share.as_f64().unwrap();
        assert!((0.0..=1.0 + 1e-9).contains(&share), "{kind} {share}");
    }
    assert!(of("none") + of("unknown") < 1.0 + 1e-9, "{probability:?}");
    assert_eq!(result["unexplained"], of("unknown") > 0.5);
    let remarkable = result["unexplained"] == true || result["effects"][0].is_object();
    assert_eq!(explained["level"], u8::from(remarkable));
    story.expect_every_frame();
    story.daemon.terminate();
}
