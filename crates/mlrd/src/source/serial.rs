use std::{fmt, io, io::Read, time::Duration};

use super::{Loss, Reading, Source};

/// A serial port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SerialLine {
    /// Name of the device.
    pub device: String,
    /// Speed.
    pub baud: u32,
}

const READ_TIMEOUT: Duration = Duration::from_millis(100);
const BUFFER: usize = 4096;
/// Bytes arrive in pieces of a few; taking them together costs a few
/// milliseconds of delay and saves most of the work.
const GATHER: Duration = Duration::from_millis(4);

struct OpenLine {
    port: Box<dyn serialport::SerialPort>,
    buffer: [u8; BUFFER],
}

impl fmt::Display for SerialLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.device)
    }
}

impl Source for SerialLine {
    fn open(&self) -> Result<Box<dyn Reading>, String> {
        let port = serialport::new(&self.device, self.baud)
            .timeout(READ_TIMEOUT)
            .open()
            .map_err(|error| format!("{}: {}", self.device, in_words(&error)))?;
        // Nobody knows how long these bytes have been waiting.
        port.clear(serialport::ClearBuffer::Input)
            .map_err(|error| format!("{}: {error}", self.device))?;
        Ok(Box::new(OpenLine {
            port,
            buffer: [0; BUFFER],
        }))
    }
}

/// Why a port cannot be opened, and what to do about it.
fn in_words(error: &serialport::Error) -> String {
    match error.kind() {
        serialport::ErrorKind::NoDevice => {
            format!("is held by another program ({error}); `fuser` tells which")
        }
        serialport::ErrorKind::Io(io::ErrorKind::NotFound) => "does not exist".into(),
        serialport::ErrorKind::Io(io::ErrorKind::PermissionDenied) => {
            "access denied; the user must be in the port's group (dialout, as a rule)".into()
        }
        _ => error.to_string(),
    }
}

impl Reading for OpenLine {
    fn read(&mut self) -> Result<Vec<u8>, Loss> {
        match self.port.read(&mut self.buffer) {
            Ok(0) => Err(Loss::Failed("the port was closed".into())),
            Ok(count) => {
                std::thread::sleep(GATHER);
                Ok(self.buffer[..count].to_vec())
            }
            Err(error)
                if matches!(
                    error.kind(),
                    io::ErrorKind::TimedOut | io::ErrorKind::Interrupted
                ) =>
            {
                Ok(Vec::new())
            }
            Err(error) => Err(Loss::Failed(error.to_string())),
        }
    }
}
