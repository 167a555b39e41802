//! Texts of strangers on a terminal: names and contents of files can hold anything.

/// Characters of a message, which is no longer than a screen.
const MAX_MESSAGE: usize = 2000;
/// Characters of one line of a message: a line of a file that is quoted leaves room for what is
/// wrong with it.
const MAX_LINE: usize = 500;

/// The text without control characters other than line feeds, and without characters that are
/// invisible or turn the direction of writing. They appear as in JSON, so that JSON means the
/// same as before.
pub fn printable(text: &str) -> String {
    let mut clean = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '\n' | ' '..='~' => clean.push(character),
            '\t' => clean.push(' '),
            // What Rust does not escape is a visible character that stands for itself.
            _ if character.escape_debug().len() == 1 => clean.push(character),
            _ => {
                for unit in character.encode_utf16(&mut [0; 2]) {
                    clean += &format!("\\u{unit:04x}");
                }
            }
        }
    }
    clean
}

/// The text as far as it fits on a screen, printable.
pub fn of_a_screen(text: &str) -> String {
    let text = printable(text);
    let lines: Vec<String> = text.lines().map(|line| shortened(line, MAX_LINE)).collect();
    shortened(&lines.join("\n"), MAX_MESSAGE)
}

fn shortened(text: &str, most: usize) -> String {
    match text.char_indices().nth(most) {
        None => text.into(),
        Some((end, _)) => {
            let (shown, rest) = text.split_at(end);
            format!("{shown}… ({} more)", rest.chars().count())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_invisible_reaches_the_terminal() {
        let hostile =
            "a\u{1b}[31m\u{7f}\u{9b}\u{202e}b\u{200b}\u{ad}\u{2066}\u{feff}\u{e0041}\r\tc";
        let clean = printable(hostile);
        assert!(
            clean.chars().all(|c| c.is_ascii_graphic() || c == ' '),
            "{clean:?}"
        );
        for usual in ["0.5° ± 2 µs: größer, …", "line 1\nline 2 \"a\\b\" 'c'"] {
            assert_eq!(printable(usual), usual);
        }
    }

    #[test]
    fn json_keeps_its_meaning() {
        let value = serde_json::json!({"log": "\u{202e}\u{1b}\u{e0041}\u{7f}ä\n\"\\"});
        let printed = printable(&value.to_string());
        assert!(printed.contains("\\u202e"), "{printed}");
        let read: serde_json::Value = serde_json::from_str(&printed).unwrap();
        assert_eq!(read, value);
    }

    #[test]
    fn a_message_fits_on_a_screen() {
        let quoted = format!("line 1\n{}\nexpected a number", "ä".repeat(1_000_000));
        let message = of_a_screen(&quoted);
        assert!(message.chars().count() < 600, "{}", message.len());
        assert!(message.contains("(999500 more)") && message.ends_with("expected a number"));
        let long = of_a_screen(&"line\n".repeat(10_000));
        assert!(long.chars().count() < 2100);
        assert_eq!(of_a_screen("short"), "short");
    }
}
