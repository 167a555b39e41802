use std::{
    fmt,
    io::{self, Stdin},
};

use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    io::Errno,
};

use super::{Loss, Reading, Source};

/// What another program writes to this one's standard input. Its end is the daemon's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StandardInput;

const TIMEOUT: Timespec = Timespec {
    tv_sec: 0,
    tv_nsec: 100_000_000,
};
const BUFFER: usize = 4096;

impl fmt::Display for StandardInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("stdin")
    }
}

impl Source for StandardInput {
    fn open(&self) -> Result<Box<dyn Reading>, String> {
        Ok(Box::new(Open {
            stdin: io::stdin(),
            buffer: [0; BUFFER],
        }))
    }
}

struct Open {
    stdin: Stdin,
    buffer: [u8; BUFFER],
}

impl Reading for Open {
    fn read(&mut self) -> Result<Vec<u8>, Loss> {
        let of_the_input = |error: Errno| match error {
            Errno::INTR | Errno::AGAIN => Ok(Vec::new()),
            error => Err(Loss::Failed(format!("stdin: {error}"))),
        };
        // Past the buffer of the standard library, whose content cannot be waited for.
        match poll(
            &mut [PollFd::new(&self.stdin, PollFlags::IN)],
            Some(&TIMEOUT),
        ) {
            Ok(0) => return Ok(Vec::new()),
            Ok(_) => {}
            Err(error) => return of_the_input(error),
        }
        match rustix::io::read(&self.stdin, &mut self.buffer) {
            Ok(0) => Err(Loss::Ended),
            Ok(count) => Ok(self.buffer[..count].to_vec()),
            Err(error) => of_the_input(error),
        }
    }
}
