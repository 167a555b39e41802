//! What the daemon says, on threads of its own: whoever does not read delays nothing.

mod queue;
mod writer;

use std::{
    fs::File,
    io,
    os::fd::AsFd,
    sync::Arc,
    time::{Duration, SystemTime},
};

pub use queue::{Dropped, Entry, Limits, OutputQueue};
pub use writer::{Expendable, Trouble, Writer};

use mlr_imu::of_a_screen;

use crate::event::{self, Kind, Status};

/// Events as JSON lines on stdout.
pub struct Events {
    writer: Writer<StatusEvent>,
    messages: Messages,
}

/// Messages for people on stderr.
#[derive(Clone)]
pub struct Messages(Arc<Writer<Message>>);

/// A `status` on its way.
struct StatusEvent {
    time: SystemTime,
    t_s: f64,
    status: Box<Status>,
}

/// One line for people.
struct Message(String);

/// `status` events say how things are: those of some minutes ago are old news.
///
/// All other events are to be kept. The longest are `identified` (2.6 kB) and `explained`
/// (13 kB); both together need ten seconds of walking. 64 MB hold those of 11 hours, or the
/// `port_lost` and `port_opened` (300 bytes, every 5 s at most) of 12 days.
const EVENTS: Limits = Limits {
    expendable: 64,
    bytes: 64_000_000,
};
/// Messages are few and short; nobody wants more of them at once.
const MESSAGES: Limits = Limits {
    expendable: 1000,
    bytes: 1_000_000,
};

impl Events {
    /// Events to stdout; what is wrong with it is told as a message.
    ///
    /// # Errors
    /// When the system has no thread or no file descriptor left.
    pub fn to_stdout(messages: Messages) -> io::Result<Self> {
        // Not through `io::stdout()`: its buffer is flushed at exit, which could wait.
        let sink = File::from(io::stdout().as_fd().try_clone_to_owned()?);
        let complaints = messages.clone();
        let complain = move |trouble: &Trouble| {
            complaints.say(&match trouble {
                Trouble::Closed => {
                    "stdout was closed: events are discarded from now on".to_string()
                }
                Trouble::Failed(error) => format!("stdout: {error}: events are lost"),
            });
        };
        Ok(Self {
            writer: Writer::start("events", EVENTS, sink, complain)?,
            messages,
        })
    }

    /// Tells what happened, by the wall clock and `t_s` after the first sample.
    pub fn tell(&self, time: SystemTime, t_s: f64, kind: Kind) {
        match kind {
            Kind::Status(status) => self
                .writer
                .write_expendable(StatusEvent { time, t_s, status }),
            kind => match event::line(time, t_s, &kind) {
                Ok(line) => self.writer.write_line(line),
                Err(error) => self.messages.say(&format!("an event is lost: {error}")),
            },
        }
    }

    /// Waits until all events are written or the patience is exhausted.
    pub fn finish(&self, patience: Duration) {
        self.writer.finish(patience);
    }
}

impl Expendable for StatusEvent {
    fn line(mut self, dropped: Dropped) -> String {
        self.status.dropped_status = dropped.expendable;
        self.status.dropped_events = dropped.lines;
        // Numbers, names and nothing else: JSON expresses them all.
        event::line(self.time, self.t_s, &Kind::Status(self.status)).unwrap_or_default()
    }
}

impl Messages {
    /// Messages to stderr.
    ///
    /// # Errors
    /// When the system has no thread or no file descriptor left.
    pub fn to_stderr() -> io::Result<Self> {
        let sink = File::from(io::stderr().as_fd().try_clone_to_owned()?);
        // There is nobody left to complain to.
        let writer = Writer::start("messages", MESSAGES, sink, |_| ())?;
        Ok(Self(Arc::new(writer)))
    }

    /// Says this, as far as it fits on a screen and without what a terminal might obey.
    pub fn say(&self, text: &str) {
        self.0.write_expendable(Message(of_a_screen(text)));
    }

    /// Waits until all messages are written or the patience is exhausted.
    pub fn finish(&self, patience: Duration) {
        self.0.finish(patience);
    }
}

impl Expendable for Message {
    fn line(self, dropped: Dropped) -> String {
        match dropped.expendable {
            0 => format!("mlrd: {}", self.0),
            count => format!(
                "mlrd: {count} messages before this one are lost\nmlrd: {}",
                self.0
            ),
        }
    }
}
