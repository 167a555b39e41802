//! Reads a serial port, whatever happens to it.

use std::{
    io::{self, Read},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
        mpsc::Sender,
    },
    thread,
    time::{Duration, Instant},
};

/// What the port has to say.
#[derive(Debug)]
pub enum PortMessage {
    /// It is open.
    Opened,
    /// It could not be opened, or failed; it is being tried again.
    Lost(String),
    /// Bytes, and when they arrived.
    Bytes(Instant, Vec<u8>),
}

const READ_TIMEOUT: Duration = Duration::from_millis(100);
const FIRST_RETRY: Duration = Duration::from_millis(200);
const LAST_RETRY: Duration = Duration::from_secs(5);
const BUFFER: usize = 4096;

/// Reads `name` until `stop` is set or nobody listens. A port that is missing,
/// busy or lost is tried again after a pause that grows up to five seconds; the
/// reason is told once per outage.
pub fn read(name: &str, baud: u32, stop: &Arc<AtomicBool>, messages: &Sender<PortMessage>) {
    let mut pause = FIRST_RETRY;
    let mut told = None;
    while !stop.load(Ordering::Relaxed) {
        let reason = match open(name, baud) {
            Ok(mut port) => {
                pause = FIRST_RETRY;
                told = None;
                if messages.send(PortMessage::Opened).is_err() {
                    return;
                }
                match forward(&mut *port, stop, messages) {
                    Some(reason) => reason,
                    None => return,
                }
            }
            Err(reason) => reason,
        };
        if told.as_ref() != Some(&reason) {
            if messages.send(PortMessage::Lost(reason.clone())).is_err() {
                return;
            }
            told = Some(reason);
        }
        thread::sleep(pause);
        pause = (pause * 2).min(LAST_RETRY);
    }
}

fn open(name: &str, baud: u32) -> Result<Box<dyn serialport::SerialPort>, String> {
    serialport::new(name, baud)
        .timeout(READ_TIMEOUT)
        .open()
        .map_err(|error| match error.kind() {
            serialport::ErrorKind::NoDevice => {
                format!("{name}: {error}; missing, or held by another program")
            }
            _ => format!("{name}: {error}"),
        })
}

/// Passes bytes on. `None` when the daemon stops, else why the port was lost.
fn forward(
    port: &mut dyn Read,
    stop: &Arc<AtomicBool>,
    messages: &Sender<PortMessage>,
) -> Option<String> {
    let mut buffer = [0; BUFFER];
    while !stop.load(Ordering::Relaxed) {
        match port.read(&mut buffer) {
            Ok(0) => return Some("the port was closed".into()),
            Ok(count) => {
                let bytes = PortMessage::Bytes(Instant::now(), buffer[..count].to_vec());
                if messages.send(bytes).is_err() {
                    return None;
                }
            }
            Err(error) if error.kind() == io::ErrorKind::TimedOut => {}
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Some(error.to_string()),
        }
    }
    None
}
