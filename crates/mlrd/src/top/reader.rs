use std::io::{self, BufRead, Read as _};

use super::told::Line;

/// Bytes of a line; the longest event is a sixtieth of it.
const LONGEST: u64 = 1_000_000;

/// The next line of the stream; `None` at its end. What is longer than any event is cut short.
///
/// # Errors
/// When the stream cannot be read.
pub(super) fn next_line(stream: &mut impl BufRead) -> io::Result<Option<Line>> {
    let mut bytes = Vec::new();
    let read = stream
        .by_ref()
        .take(LONGEST)
        .read_until(b'\n', &mut bytes)?;
    if read == 0 {
        return Ok(None);
    }
    if bytes.last() != Some(&b'\n') && read as u64 == LONGEST {
        stream.skip_until(b'\n')?;
    }
    let text = String::from_utf8_lossy(&bytes);
    Ok(Some(Line::new(text.trim_end_matches(['\r', '\n']))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_bounded_and_need_no_end() {
        let long = "x".repeat(3_000_000);
        let text = format!("a\r\n{long}\n\nb\u{fffd}");
        let mut stream = text.as_bytes();
        let mut lines = Vec::new();
        while let Some(Line::Other(line)) = next_line(&mut stream).unwrap() {
            lines.push(line);
        }
        assert_eq!(lines.len(), 4);
        assert_eq!((lines[0].as_str(), lines[1].len()), ("a", LONGEST as usize));
        assert_eq!((lines[2].as_str(), lines[3].as_str()), ("", "b\u{fffd}"));
        let mut broken: &[u8] = b"\xff\xfe";
        assert!(next_line(&mut broken).unwrap().is_some());
    }
}
