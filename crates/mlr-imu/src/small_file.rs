//! Files that are small by nature: settings, descriptions, states.

use std::{
    fs::File,
    io::{self, Read},
    path::Path,
};

/// The most that is read of a file that a person writes, in bytes.
pub const MAX_TEXT_BYTES: u64 = 1_000_000;

/// Reads a text file like [`std::fs::read_to_string`], but no more of it than `max_bytes`.
///
/// # Errors
/// Whatever opening and reading returns; [`io::ErrorKind::FileTooLarge`] when there is more, and
/// [`io::ErrorKind::InvalidData`] naming the line that is no text.
pub fn read_text(path: &Path, max_bytes: u64) -> io::Result<String> {
    let mut bytes = Vec::new();
    // One byte more than may be there tells that there is more.
    let most = max_bytes.saturating_add(1);
    File::open(path)?.take(most).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > max_bytes {
        return Err(io::Error::new(
            io::ErrorKind::FileTooLarge,
            format!(
                "is larger than {} kB, the most that is read of such a file",
                max_bytes.div_ceil(1000)
            ),
        ));
    }
    String::from_utf8(bytes).map_err(|error| {
        let (text, _) = error.as_bytes().split_at(error.utf8_error().valid_up_to());
        let line = 1 + text.iter().filter(|byte| **byte == b'\n').count();
        io::Error::new(
            io::ErrorKind::InvalidData,
            format!("line {line} is not UTF-8 text"),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_up_to_its_bound() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("robot.toml");
        std::fs::write(&path, "name = 'ä'").unwrap();
        assert_eq!(read_text(&path, 11).unwrap(), "name = 'ä'");
        let error = read_text(&path, 10).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::FileTooLarge);
        assert!(error.to_string().contains("1 kB"), "{error}");
        let missing = read_text(&folder.path().join("none"), 10).unwrap_err();
        assert_eq!(missing.kind(), io::ErrorKind::NotFound);
    }

    #[test]
    fn a_line_that_is_no_text_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("robot.toml");
        std::fs::write(&path, b"a = 1\nb = '\xe4'\n").unwrap();
        let error = read_text(&path, 100).unwrap_err().to_string();
        assert_eq!(error, "line 2 is not UTF-8 text");
    }

    #[cfg(unix)]
    #[test]
    fn an_endless_file_ends() {
        let error = read_text(Path::new("/dev/zero"), MAX_TEXT_BYTES).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::FileTooLarge);
    }
}
