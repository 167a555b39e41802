//! Where the bytes come from, whatever happens to it.

mod i2c;
mod serial;
mod stdin;

pub use i2c::I2cBus;
pub use serial::SerialLine;
pub use stdin::StandardInput;

use std::{
    fmt,
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU64, Ordering},
        mpsc::SyncSender,
    },
    thread,
    time::{Duration, Instant},
};

/// What the source has to say.
#[derive(Debug)]
pub enum SourceMessage {
    /// It is open.
    Opened,
    /// It could not be opened, or failed; it is being tried again.
    Lost(String),
    /// Bytes, and when they arrived.
    Bytes(Instant, Vec<u8>),
    /// It has ended for good.
    Ended,
}

/// Something that can be opened and read, again and again. Its name is how it
/// displays itself.
pub trait Source: Send + fmt::Display {
    /// Opens it. `Err` says why it could not be, in words for people.
    fn open(&self) -> Result<Box<dyn Reading>, String>;
}

/// A source that is open.
pub trait Reading {
    /// Waits for bytes for a moment, a tenth of a second at most; none is no
    /// error. `Err` says why the source is lost.
    fn read(&mut self) -> Result<Vec<u8>, Loss>;
}

/// Why a source gives no more bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Loss {
    /// It failed, as it says in words for people, and may come back.
    Failed(String),
    /// There is no more of it.
    Ended,
}

/// Counts what the reading thread does, so that its health can be seen.
#[derive(Debug, Clone, Default)]
pub struct Pulse(Arc<AtomicU64>);

impl Pulse {
    /// How often the thread has come round.
    pub fn count(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }

    fn beat(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

const FIRST_RETRY: Duration = Duration::from_millis(200);
const LAST_RETRY: Duration = Duration::from_secs(5);
/// A source that stays open for so long has recovered: the next outage is
/// retried quickly again.
const RECOVERED: Duration = Duration::from_secs(10);

/// Reads until `stop` is set or nobody listens. Waits where the messages are not taken. A source that is missing, busy
/// or lost is tried again after a pause that grows up to five seconds; the
/// reason is told once per outage.
pub fn read(
    source: &dyn Source,
    stop: &AtomicBool,
    pulse: &Pulse,
    messages: &SyncSender<SourceMessage>,
) {
    let mut pause = FIRST_RETRY;
    let mut told = None;
    while !stop.load(Ordering::Relaxed) {
        let reason = match source.open() {
            Ok(mut open) => {
                told = None;
                if messages.send(SourceMessage::Opened).is_err() {
                    return;
                }
                let opened = Instant::now();
                let reason = match forward(&mut *open, stop, pulse, messages) {
                    Some(Loss::Failed(reason)) => reason,
                    Some(Loss::Ended) => {
                        // Nobody listens, or whoever does will end.
                        let _ = messages.send(SourceMessage::Ended);
                        return;
                    }
                    None => return,
                };
                if opened.elapsed() > RECOVERED {
                    pause = FIRST_RETRY;
                }
                reason
            }
            Err(reason) => reason,
        };
        if told.as_ref() != Some(&reason) {
            if messages.send(SourceMessage::Lost(reason.clone())).is_err() {
                return;
            }
            told = Some(reason);
        }
        wait(pause, stop, pulse);
        pause = (pause * 2).min(LAST_RETRY);
    }
}

/// Waits, but not beyond the daemon's end.
fn wait(pause: Duration, stop: &AtomicBool, pulse: &Pulse) {
    let end = Instant::now() + pause;
    while !stop.load(Ordering::Relaxed) {
        pulse.beat();
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return;
        }
        thread::sleep(left.min(FIRST_RETRY));
    }
}

/// How long bytes are read after the daemon was told to stop: those that have arrived by
/// then are still taken.
const LAST_BYTES: Duration = Duration::from_millis(50);

/// Passes bytes on. `None` when the daemon stops, else why the source was lost.
fn forward(
    open: &mut dyn Reading,
    stop: &AtomicBool,
    pulse: &Pulse,
    messages: &SyncSender<SourceMessage>,
) -> Option<Loss> {
    let mut end = None;
    while end.is_none_or(|end| Instant::now() < end) {
        pulse.beat();
        let bytes = match open.read() {
            Ok(bytes) => bytes,
            Err(loss) => return Some(loss),
        };
        if stop.load(Ordering::Relaxed) {
            if bytes.is_empty() {
                return None;
            }
            end = end.or(Some(Instant::now() + LAST_BYTES));
        }
        if !bytes.is_empty() {
            let message = SourceMessage::Bytes(Instant::now(), bytes);
            if messages.send(message).is_err() {
                return None;
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use std::sync::{Mutex, mpsc};

    use super::*;

    /// Fails to open twice, then delivers one byte per read, and is lost after
    /// three.
    #[derive(Default)]
    struct Flaky(Arc<Mutex<usize>>);

    struct Open(usize);

    impl fmt::Display for Flaky {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("flaky")
        }
    }

    impl Source for Flaky {
        fn open(&self) -> Result<Box<dyn Reading>, String> {
            let mut tries = self.0.lock().unwrap();
            *tries += 1;
            if *tries <= 2 {
                return Err("missing".into());
            }
            Ok(Box::new(Open(0)))
        }
    }

    impl Reading for Open {
        fn read(&mut self) -> Result<Vec<u8>, Loss> {
            self.0 += 1;
            if self.0 > 3 {
                return Err(Loss::Failed("unplugged".into()));
            }
            Ok(vec![7])
        }
    }

    #[test]
    fn is_tried_again_and_every_outage_is_told_once() {
        let (send, messages) = mpsc::sync_channel(1);
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let thread =
            thread::spawn(move || read(&Flaky::default(), &stopped, &Pulse::default(), &send));
        let told: Vec<String> = messages
            .iter()
            .take(10)
            .map(|message| match message {
                SourceMessage::Opened => "opened".into(),
                SourceMessage::Lost(reason) => reason,
                SourceMessage::Bytes(_, bytes) => format!("{bytes:?}"),
                SourceMessage::Ended => "ended".into(),
            })
            .collect();
        stop.store(true, Ordering::Relaxed);
        let outage = ["opened", "[7]", "[7]", "[7]", "unplugged"];
        let expected: Vec<&str> = ["missing"]
            .into_iter()
            .chain(outage)
            .chain(outage)
            .take(10)
            .collect();
        assert_eq!(told, expected);
        drop(messages);
        thread.join().unwrap();
    }
}
