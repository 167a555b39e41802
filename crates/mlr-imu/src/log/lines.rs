//! The lines of a text of any length, in bounded memory.

use std::io::{self, BufRead, BufReader, Read};

use super::{LogLimits, LogProblem};

/// A byte-order mark, which spreadsheets put before the first name.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// The lines of a text, one after the other.
pub(super) struct Lines<R> {
    text: BufReader<R>,
    limits: LogLimits,
    line: Vec<u8>,
    /// What ends a line: line feed, or the carriage return of old Macintoshes.
    end: u8,
    /// Lines read.
    count: u64,
    /// Bytes read.
    bytes: u64,
}

/// One line, without its end.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line<'a> {
    /// From 1.
    pub(super) number: u64,
    pub(super) text: &'a [u8],
    /// Whether it has an end: the last line of a file that was cut has none.
    pub(super) is_ended: bool,
}

impl<R: Read> Lines<R> {
    pub(super) fn new(text: R, limits: LogLimits) -> Result<Self, LogProblem> {
        let mut text = BufReader::new(text);
        let start = text.fill_buf().map_err(|error| unreadable(error, 1))?;
        let returns_only = start.contains(&b'\r') && !start.contains(&b'\n');
        Ok(Self {
            text,
            limits,
            line: Vec::new(),
            end: if returns_only { b'\r' } else { b'\n' },
            count: 0,
            bytes: 0,
        })
    }

    /// The next line; `None` behind the last.
    ///
    /// # Errors
    /// [`LogProblem`] when the text cannot be read, or exceeds a limit.
    pub(super) fn next(&mut self) -> Result<Option<Line<'_>>, LogProblem> {
        let number = self.count + 1;
        let LogLimits {
            max_line_bytes,
            max_bytes,
            ..
        } = self.limits;
        self.line.clear();
        // One byte more than may be there tells that there is more.
        let most = (max_line_bytes as u64).saturating_add(1);
        let read = (&mut self.text)
            .take(most)
            .read_until(self.end, &mut self.line)
            .map_err(|error| unreadable(error, number))?;
        if read == 0 {
            return Ok(None);
        }
        self.count = number;
        self.bytes += read as u64;
        let is_ended = self.line.last() == Some(&self.end);
        let mut text = self.line.as_slice();
        if is_ended {
            text = &text[..text.len() - 1];
        }
        if text.len() > max_line_bytes {
            return Err(LogProblem::LineTooLong {
                line: number,
                max_bytes: max_line_bytes,
            });
        }
        if self.bytes > max_bytes {
            return Err(LogProblem::TooMuchText {
                line: number,
                max_bytes,
            });
        }
        if number == 1 {
            text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text);
        }
        Ok(Some(Line {
            number,
            text: text.strip_suffix(b"\r").unwrap_or(text),
            is_ended,
        }))
    }
}

/// What a failure to read the given line means.
pub(super) fn unreadable(source: io::Error, line: u64) -> LogProblem {
    match source.kind() {
        // What the gzip decoder reports for data cut short or damaged.
        io::ErrorKind::UnexpectedEof | io::ErrorKind::InvalidInput | io::ErrorKind::InvalidData => {
            LogProblem::Gzip { line, source }
        }
        _ => LogProblem::Io(source),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<(u64, String, bool)> {
        let mut lines = Lines::new(text.as_bytes(), LogLimits::default()).unwrap();
        let mut all = Vec::new();
        while let Some(line) = lines.next().unwrap() {
            let text = String::from_utf8(line.text.to_vec()).unwrap();
            all.push((line.number, text, line.is_ended));
        }
        all
    }

    #[test]
    fn every_kind_of_line_end() {
        for text in ["a\nb\n", "a\r\nb\r\n", "a\rb\r", "\u{feff}a\nb\n"] {
            let expected = [(1, "a".to_string(), true), (2, "b".to_string(), true)];
            assert_eq!(lines(text), expected, "{text:?}");
        }
        assert_eq!(lines("a\n\nb")[2], (3, "b".to_string(), false));
        assert!(lines("").is_empty());
    }

    #[test]
    fn a_line_and_a_text_have_limits() {
        let limits = LogLimits {
            max_line_bytes: 10,
            max_bytes: 100,
            ..LogLimits::default()
        };
        // Endless, and no more is held of it than a line.
        let mut endless = Lines::new(io::repeat(b'x'), limits).unwrap();
        let problem = endless.next().unwrap_err();
        assert!(matches!(problem, LogProblem::LineTooLong { line: 1, .. }));
        assert!(endless.line.capacity() < 100);

        let fits = format!("{}\n", "x".repeat(10));
        let text = fits.repeat(10);
        let mut lines = Lines::new(text.as_bytes(), limits).unwrap();
        for _ in 0..9 {
            lines.next().unwrap().unwrap();
        }
        let problem = lines.next().unwrap_err();
        assert!(matches!(problem, LogProblem::TooMuchText { line: 10, .. }));
    }
}
