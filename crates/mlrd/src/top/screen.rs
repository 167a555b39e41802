use std::{
    io::{self, BufRead},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
        mpsc::{self, Receiver, TryRecvError},
    },
    thread,
    time::{Duration, Instant},
};

use anyhow::Context;
use ratatui::{
    DefaultTerminal,
    crossterm::event::{self, Event, KeyCode, KeyEvent, KeyModifiers},
};
use rustix::process::{Signal, kill_current_process_group};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use super::{
    drawing::{Palette, View, draw},
    picture::Picture,
    reader,
    told::Line,
};

/// How long keys are waited for before the stream is looked at.
const TICK: Duration = Duration::from_millis(50);
/// How often the picture is drawn while nothing changes: the silence grows.
const REDRAW: Duration = Duration::from_secs(1);
/// Lines on their way from the stream.
const WAITING: usize = 1024;
/// Lines that one key moves the list of events.
const PAGE: usize = 10;

/// Why the view ended.
enum Left {
    Quit,
    /// Ctrl-C, which in raw mode is a key, and otherwise would have ended the whole pipeline.
    Interrupted,
    Terminated,
}

/// Draws the picture that follows from the stream until a key or a signal ends it. The terminal is
/// as before then, also after a panic.
pub(super) fn show(
    stream: impl BufRead + Send + 'static,
    picture: Picture,
    palette: Palette,
) -> anyhow::Result<()> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGHUP, SIGINT, SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop)).context("signals")?;
    }
    let lines = read_in_a_thread(stream).context("threads")?;
    let mut screen = Screen {
        picture,
        view: View {
            palette,
            silent: Duration::ZERO,
            ended: false,
            scrolled_back: 0,
        },
        last_line: Instant::now(),
    };
    // Its hook restores the terminal before a panic is reported.
    let mut terminal = ratatui::try_init().context("terminal")?;
    let left = screen.run(&mut terminal, &lines, &stop);
    // A terminal that is gone cannot be restored.
    let _ = ratatui::try_restore();
    if let Left::Interrupted = left.context("terminal")? {
        // Whoever feeds the stream is in this group, as is this process, which takes no notice.
        let _ = kill_current_process_group(Signal::INT);
    }
    Ok(())
}

fn read_in_a_thread(
    mut stream: impl BufRead + Send + 'static,
) -> io::Result<Receiver<io::Result<Line>>> {
    let (send, lines) = mpsc::sync_channel(WAITING);
    let read = move || {
        while let Some(line) = reader::next_line(&mut stream).transpose() {
            let failed = line.is_err();
            if send.send(line).is_err() || failed {
                return;
            }
        }
    };
    thread::Builder::new().name("stream".into()).spawn(read)?;
    Ok(lines)
}

struct Screen {
    picture: Picture,
    view: View,
    last_line: Instant,
}

impl Screen {
    fn run(
        &mut self,
        terminal: &mut DefaultTerminal,
        lines: &Receiver<io::Result<Line>>,
        stop: &AtomicBool,
    ) -> io::Result<Left> {
        let mut drawn: Option<Instant> = None;
        while !stop.load(Ordering::Relaxed) {
            let changed = self.take(lines);
            if changed || drawn.is_none_or(|drawn| drawn.elapsed() >= REDRAW) {
                self.view.silent = self.last_line.elapsed();
                terminal.draw(|frame| draw(frame, &self.picture, &self.view))?;
                drawn = Some(Instant::now());
            }
            if !event::poll(TICK)? {
                continue;
            }
            match event::read()? {
                Event::Key(key) if key.is_press() => {
                    if let Some(left) = self.press(key) {
                        return Ok(left);
                    }
                }
                Event::Resize(..) => {}
                _ => continue,
            }
            drawn = None;
        }
        Ok(Left::Terminated)
    }

    /// Takes the lines that wait. Says whether there were any.
    fn take(&mut self, lines: &Receiver<io::Result<Line>>) -> bool {
        let mut changed = false;
        // No more than fit into the channel: keys are not kept waiting by a long file.
        for _ in 0..WAITING {
            match lines.try_recv() {
                Ok(Ok(line)) => {
                    let before = self.picture.entries.len();
                    self.picture.apply(&line);
                    if self.view.scrolled_back > 0 {
                        // What is read stays where it is.
                        let more = self.picture.entries.len().saturating_sub(before);
                        self.view.scrolled_back += more;
                    }
                }
                Ok(Err(error)) => {
                    let text = format!("the stream cannot be read: {error}");
                    self.picture.apply(&Line::Other(text));
                }
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => {
                    changed |= !self.view.ended;
                    self.view.ended = true;
                    break;
                }
            }
            self.last_line = Instant::now();
            changed = true;
        }
        changed
    }

    fn press(&mut self, key: KeyEvent) -> Option<Left> {
        let scrolled_back = &mut self.view.scrolled_back;
        match key.code {
            KeyCode::Char('c') if key.modifiers.contains(KeyModifiers::CONTROL) => {
                return Some(Left::Interrupted);
            }
            KeyCode::Char('q' | 'Q') => return Some(Left::Quit),
            KeyCode::Up | KeyCode::Char('k') => *scrolled_back += 1,
            KeyCode::Down | KeyCode::Char('j') => *scrolled_back = scrolled_back.saturating_sub(1),
            KeyCode::PageUp => *scrolled_back += PAGE,
            KeyCode::PageDown => *scrolled_back = scrolled_back.saturating_sub(PAGE),
            KeyCode::End => *scrolled_back = 0,
            _ => {}
        }
        let oldest = self.picture.entries.len().saturating_sub(1);
        self.view.scrolled_back = self.view.scrolled_back.min(oldest);
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event::WatchedRobot;

    #[test]
    fn keys_leave_and_scroll_and_the_end_is_seen() {
        let jethexa = WatchedRobot::new(&mlr_model::Robot::jethexa());
        let mut screen = Screen {
            picture: Picture::new(jethexa),
            view: View {
                palette: Palette::Plain,
                silent: Duration::ZERO,
                ended: false,
                scrolled_back: 0,
            },
            last_line: Instant::now(),
        };
        let (send, lines) = mpsc::sync_channel(WAITING);
        assert!(!screen.take(&lines));
        for text in ["one", "two", "three"] {
            send.send(Ok(Line::Other(text.into()))).unwrap();
        }
        assert!(screen.take(&lines));
        for expected in [1, 2, 2] {
            assert!(screen.press(KeyCode::Up.into()).is_none());
            assert_eq!(screen.view.scrolled_back, expected);
        }
        // What comes does not move what is read.
        send.send(Ok(Line::Other("four".into()))).unwrap();
        screen.take(&lines);
        assert_eq!(screen.view.scrolled_back, 3);
        screen.press(KeyCode::End.into());
        assert_eq!(screen.view.scrolled_back, 0);
        drop(send);
        assert!(screen.take(&lines) && screen.view.ended);
        assert!(!screen.take(&lines));
        let interrupt = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
        assert!(matches!(screen.press(interrupt), Some(Left::Interrupted)));
        assert!(screen.press(KeyCode::Char('c').into()).is_none());
        let q = screen.press(KeyCode::Char('q').into());
        assert!(matches!(q, Some(Left::Quit)));
    }
}
