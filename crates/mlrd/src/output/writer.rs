//! Writes lines without ever making anybody wait.

use std::{
    io::{self, ErrorKind, Write},
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
    thread,
    time::Duration,
};

use super::queue::{Dropped, Entry, Limits, OutputQueue};

/// What may be dropped when nobody reads.
pub trait Expendable: Send + 'static {
    /// Its line without the line end; `dropped` is what was dropped before it.
    fn line(self, dropped: Dropped) -> String;
}

/// Hands lines to a thread that writes them. Only that thread waits when the reader does
/// not read.
pub struct Writer<E> {
    shared: Arc<Shared<E>>,
}

struct Shared<E> {
    state: Mutex<State<E>>,
    changed: Condvar,
}

struct State<E> {
    queue: OutputQueue<E>,
    /// A line is being written.
    writing: bool,
    /// Nobody will ever read again.
    closed: bool,
}

/// Why lines are not written, told once each.
#[derive(Debug)]
pub enum Trouble {
    /// Nobody reads any more: everything is discarded from now on.
    Closed,
    /// The line written last is lost.
    Failed(io::Error),
}

/// Pause before a sink that takes no bytes at the moment is tried again.
const RETRY: Duration = Duration::from_millis(10);

impl<E: Expendable> Writer<E> {
    /// Begins to write to `sink`, on a thread of this name; `complain` hears of trouble.
    ///
    /// # Errors
    /// When no thread is to be had.
    pub fn start(
        name: &str,
        limits: Limits,
        sink: impl Write + Send + 'static,
        complain: impl Fn(&Trouble) + Send + 'static,
    ) -> io::Result<Self> {
        let shared = Arc::new(Shared {
            state: Mutex::new(State {
                queue: OutputQueue::new(limits),
                writing: false,
                closed: false,
            }),
            changed: Condvar::new(),
        });
        let writing = Arc::clone(&shared);
        thread::Builder::new()
            .name(name.into())
            .spawn(move || writing.write_to(sink, complain))?;
        Ok(Self { shared })
    }

    /// Writes what may be dropped.
    pub fn write_expendable(&self, entry: E) {
        self.push(|queue| queue.push_expendable(entry));
    }

    /// Writes a line; it has no line end.
    pub fn write_line(&self, line: String) {
        self.push(|queue| queue.push_line(line));
    }

    /// Waits until everything is written or the patience is exhausted.
    pub fn finish(&self, patience: Duration) {
        let unfinished =
            |state: &mut State<E>| !state.closed && (state.writing || !state.queue.is_empty());
        let waited =
            self.shared
                .changed
                .wait_timeout_while(self.shared.lock(), patience, unfinished);
        drop(waited);
    }

    fn push(&self, append: impl FnOnce(&mut OutputQueue<E>)) {
        let mut state = self.shared.lock();
        if !state.closed {
            append(&mut state.queue);
            self.shared.changed.notify_all();
        }
    }
}

impl<E: Expendable> Shared<E> {
    /// What a thread that died has left is still whole.
    fn lock(&self) -> MutexGuard<'_, State<E>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn write_to(&self, mut sink: impl Write, complain: impl Fn(&Trouble)) {
        let mut failing = false;
        // What is left of a line that failed must not run into the next.
        let mut broken_line = false;
        loop {
            let mut line = match self.next() {
                Entry::Line(line) => line,
                Entry::Expendable(entry, dropped) => entry.line(dropped),
            };
            line.push('\n');
            if broken_line {
                line.insert(0, '\n');
            }
            match write_all(&mut sink, line.as_bytes()) {
                Ok(()) => {
                    failing = false;
                    broken_line = false;
                }
                Err(failure) if failure.error.kind() == ErrorKind::BrokenPipe => {
                    let mut state = self.lock();
                    state.closed = true;
                    state.queue.clear();
                    drop(state);
                    self.changed.notify_all();
                    complain(&Trouble::Closed);
                    return;
                }
                Err(failure) => {
                    broken_line |= failure.written > 0;
                    if !std::mem::replace(&mut failing, true) {
                        complain(&Trouble::Failed(failure.error));
                    }
                }
            }
        }
    }

    /// Waits for the next entry; the one before it is done.
    fn next(&self) -> Entry<E> {
        let mut state = self.lock();
        state.writing = false;
        loop {
            if let Some(entry) = state.queue.pop() {
                state.writing = true;
                return entry;
            }
            self.changed.notify_all();
            state = self
                .changed
                .wait(state)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// Why a line was not written to its end.
struct Failure {
    written: usize,
    error: io::Error,
}

/// Writes all bytes, also to a sink that somebody has made non-blocking.
fn write_all(sink: &mut impl Write, bytes: &[u8]) -> Result<(), Failure> {
    let mut written = 0;
    while let Some(rest) = bytes.get(written..).filter(|rest| !rest.is_empty()) {
        match sink.write(rest) {
            Ok(0) => {
                let error = ErrorKind::WriteZero.into();
                return Err(Failure { written, error });
            }
            Ok(count) => written += count,
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) if error.kind() == ErrorKind::WouldBlock => thread::sleep(RETRY),
            Err(error) => return Err(Failure { written, error }),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::{
        io::{BufRead, BufReader, pipe},
        sync::mpsc,
        time::Instant,
    };

    use super::*;

    /// A number, and how many were dropped before it.
    struct Count(u32);

    impl Expendable for Count {
        fn line(self, dropped: Dropped) -> String {
            format!("{} {}", self.0, dropped.expendable)
        }
    }

    const LIMITS: Limits = Limits {
        expendable: 2,
        bytes: 10_000_000,
    };
    /// Ends a hang.
    const LONG: Duration = Duration::from_secs(1800);

    /// A line larger than any pipe.
    fn large() -> String {
        "x".repeat(2_000_000)
    }

    #[test]
    fn a_reader_that_pauses_gets_every_line_and_is_told_of_what_was_dropped() {
        let (reader, sink) = pipe().unwrap();
        let writer = Writer::start("test", LIMITS, sink, |_| ()).unwrap();
        let begin = Instant::now();
        writer.write_line(large());
        while !writer.shared.lock().writing {
            thread::yield_now();
        }
        writer.write_line("second".into());
        for number in 0..10 {
            writer.write_expendable(Count(number));
        }
        writer.finish(Duration::from_millis(50));
        assert!(begin.elapsed() < LONG / 2, "nobody reads");
        let read = thread::spawn(|| {
            let lines = BufReader::new(reader).lines().skip(1).take(3);
            lines.map(Result::unwrap).collect::<Vec<String>>()
        });
        writer.finish(LONG);
        assert_eq!(read.join().unwrap(), ["second", "8 8", "9 0"]);
    }

    #[test]
    fn a_closed_pipe_is_told_once_and_nothing_is_kept() {
        let (reader, sink) = pipe().unwrap();
        let (tell, told) = mpsc::channel();
        let complain = move |trouble: &Trouble| tell.send(format!("{trouble:?}")).unwrap();
        let writer = Writer::<Count>::start("test", LIMITS, sink, complain).unwrap();
        writer.write_line(large());
        drop(reader);
        assert_eq!(told.recv_timeout(LONG).unwrap(), "Closed");
        for _ in 0..100 {
            writer.write_line("more".into());
        }
        writer.finish(LONG);
        assert!(writer.shared.lock().queue.is_empty());
        assert!(told.recv().is_err(), "the thread has ended");
    }

    /// Takes three bytes, has no room for a while, is full once, and then takes all.
    struct Troubled {
        calls: usize,
        written: mpsc::Sender<Vec<u8>>,
    }

    impl Write for Troubled {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.calls += 1;
            let count = match self.calls {
                1 => 3,
                2 => return Err(ErrorKind::WouldBlock.into()),
                3 => return Err(ErrorKind::Interrupted.into()),
                4 => 2,
                5 => return Err(ErrorKind::StorageFull.into()),
                _ => bytes.len(),
            };
            self.written.send(bytes[..count].to_vec()).unwrap();
            Ok(count)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_line_that_failed_is_told_and_the_next_begins_anew() {
        let (send, written) = mpsc::channel();
        let (tell, told) = mpsc::channel();
        let sink = Troubled {
            calls: 0,
            written: send,
        };
        let complain = move |trouble: &Trouble| tell.send(format!("{trouble:?}")).unwrap();
        let writer = Writer::<Count>::start("test", LIMITS, sink, complain).unwrap();
        writer.write_line("first line".into());
        writer.write_line("second".into());
        writer.finish(LONG);
        let text: Vec<u8> = written.try_iter().flatten().collect();
        assert_eq!(String::from_utf8(text).unwrap(), "first\nsecond\n");
        assert!(told.try_recv().unwrap().contains("StorageFull"));
        assert!(told.try_recv().is_err());
    }
}
