//! What the daemon tells systemd.

use std::time::{Duration, Instant};

use sd_notify::NotifyState;

use crate::output::Messages;

/// Tells readiness, status and life to the service manager, if there is one.
///
/// The watchdog is fed only while work gets done: either readings have been
/// processed since the last time, or there are none to process while the thread
/// that waits for them is alive. A sensor that is unplugged is no reason to be
/// restarted, frames that pile up are.
pub struct Supervisor {
    messages: Messages,
    feed_every: Option<Duration>,
    last_fed: Instant,
    then: Progress,
}

/// How far the daemon has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Progress {
    /// Pieces of bytes processed.
    pub processed: u64,
    /// Rounds of the reading thread.
    pub pulse: u64,
    /// Whether there was nothing to process when last looked.
    pub idle: bool,
}

impl Progress {
    fn is_alive_since(&self, then: &Self) -> bool {
        self.processed > then.processed || (self.idle && self.pulse > then.pulse)
    }
}

/// The watchdog is fed twice in the time after which it bites.
const SAFETY: u32 = 2;

impl Supervisor {
    /// The daemon is ready.
    pub fn ready(messages: Messages) -> Self {
        let supervisor = Self {
            messages,
            feed_every: sd_notify::watchdog_enabled().map(|limit| limit / SAFETY),
            last_fed: Instant::now(),
            then: Progress::default(),
        };
        supervisor.notify(NotifyState::Ready);
        supervisor
    }

    /// Feeds the watchdog when it is time and progress was made.
    pub fn feed(&mut self, now: Progress) {
        let Some(every) = self.feed_every else {
            return;
        };
        if self.last_fed.elapsed() >= every && now.is_alive_since(&self.then) {
            self.notify(NotifyState::Watchdog);
            self.last_fed = Instant::now();
            self.then = now;
        }
    }

    /// Shows what the daemon does, as in `systemctl status`.
    pub fn status(&self, text: &str) {
        self.notify(NotifyState::Status(text));
    }

    /// The daemon is ending.
    pub fn stopping(&self) {
        self.notify(NotifyState::Stopping);
    }

    /// Without a service manager this does nothing.
    fn notify(&self, state: NotifyState<'_>) {
        if let Err(error) = sd_notify::notify(&[state]) {
            // The journal may still be read when systemd does not listen.
            self.messages.say(&format!("systemd: {error}"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn life_is_work_done_or_nothing_to_do() {
        let then = Progress {
            processed: 10,
            pulse: 10,
            idle: true,
        };
        let now = |processed, pulse, idle| {
            Progress {
                processed,
                pulse,
                idle,
            }
            .is_alive_since(&then)
        };
        assert!(now(11, 10, false), "bytes were processed");
        assert!(now(10, 11, true), "nothing came, the reader waits");
        assert!(!now(10, 11, false), "bytes pile up");
        assert!(!now(10, 10, true), "the reader hangs");
    }
}
