//! The daemon at the speed of life, over pseudo-terminals, for every framing.
//! Takes four minutes:
//!
//! ```text
//! cargo test --release -p mlrd --test onboard -- real_time --ignored --nocapture --test-threads 1
//! ```
#![allow(clippy::print_stdout, reason = "what was measured is shown")]

use std::thread;

use crate::daemon::{
    Daemon, LOG, expect_legs_3_and_4,
    player::{DEVICES, Line, corrupt, play_in_real_time},
};

/// One daemon per framing, all at once. All are started before the first port is
/// opened, so that none inherits another's.
fn every_framing(with_corruption: bool, with_outage: bool) {
    let folder = tempfile::tempdir().unwrap();
    let daemons = DEVICES.map(|device| {
        let port = folder.path().join(format!("{device:?}"));
        let daemon = Daemon::start(["--port", port.to_str().unwrap(), "--threads", "1"]);
        daemon.next("port_lost");
        (device, port, daemon)
    });
    let threads = daemons.map(|(device, port, daemon)| {
        thread::spawn(move || {
            let line = Line::plugged_in(&port);
            daemon.next("port_opened");
            let mut frames = device.frames(LOG);
            if with_corruption {
                corrupt(&mut frames);
            }
            let player = thread::spawn(move || play_in_real_time(line, &frames, with_outage));
            println!("{device:?}");
            expect_legs_3_and_4(&daemon);
            player.join().unwrap();
            daemon.terminate();
            println!("{device:?}: as expected");
        })
    });
    let failed = threads.map(|thread| thread.join().is_err());
    assert_eq!(failed, [false; 5], "in the order of {DEVICES:?}");
}

#[test]
#[ignore = "takes more than a minute"]
fn clean_line() {
    every_framing(false, false);
}

#[test]
#[ignore = "takes more than a minute"]
fn one_byte_in_a_hundred_frames_corrupted() {
    every_framing(true, false);
}

#[test]
#[ignore = "takes more than a minute"]
fn unplugged_and_replugged_during_the_walk() {
    every_framing(false, true);
}
