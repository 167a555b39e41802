//! The fields of a line.

use csv_core::{ReadRecordResult, Reader, ReaderBuilder};

/// What separates the fields of a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Delimiter {
    /// One character.
    Character(u8),
    /// Any number of spaces and tabs.
    Spaces,
}

impl Delimiter {
    /// The one that the header is written with: whichever of tab, semicolon and comma is there
    /// most often outside of quotes, else spaces.
    pub(super) fn of_header(header: &[u8]) -> Self {
        let mut counts = [(b'\t', 0), (b';', 0), (b',', 0)];
        let mut quoted = false;
        for byte in header.trim_ascii() {
            quoted ^= *byte == b'"';
            let separator = counts.iter_mut().find(|(separator, _)| separator == byte);
            if let Some((_, count)) = separator.filter(|_| !quoted) {
                *count += 1;
            }
        }
        // Of equally many the last wins: the comma, as in the name of the format.
        match counts.into_iter().max_by_key(|(_, count)| *count) {
            Some((separator, 1..)) => Self::Character(separator),
            _ if header.trim_ascii().contains(&b' ') => Self::Spaces,
            _ => Self::Character(b','),
        }
    }

    /// Whether a comma within a field can belong to a number.
    pub(super) fn leaves_commas_to_numbers(self) -> bool {
        self != Self::Character(b',')
    }
}

/// Splits lines into fields, without more memory than a line takes.
#[derive(Debug)]
pub(super) struct Splitter {
    delimiter: Delimiter,
    reader: Reader,
    /// The fields of a line, one behind the other, and where each ends.
    text: Vec<u8>,
    ends: Vec<usize>,
}

/// The fields of one line, without spaces and quotes around them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fields<'a> {
    text: &'a [u8],
    ends: &'a [usize],
}

impl Splitter {
    pub(super) fn new(delimiter: Delimiter, max_fields: usize) -> Self {
        let mut builder = ReaderBuilder::new();
        if let Delimiter::Character(separator) = delimiter {
            builder.delimiter(separator);
        }
        Self {
            delimiter,
            reader: builder.build(),
            text: Vec::new(),
            ends: vec![0; max_fields],
        }
    }

    /// The fields of a line; `None` if there are too many of them.
    pub(super) fn split(&mut self, line: &[u8]) -> Option<Fields<'_>> {
        let count = match self.delimiter {
            Delimiter::Character(_) => self.split_quoted(line),
            Delimiter::Spaces => self.split_at_spaces(line),
        }?;
        Some(Fields {
            text: &self.text,
            ends: self.ends.get(..count)?,
        })
    }

    fn split_at_spaces(&mut self, line: &[u8]) -> Option<usize> {
        self.text.clear();
        let mut count = 0;
        let fields = line.split(u8::is_ascii_whitespace);
        for field in fields.filter(|field| !field.is_empty()) {
            self.text.extend_from_slice(field);
            *self.ends.get_mut(count)? = self.text.len();
            count += 1;
        }
        Some(count)
    }

    fn split_quoted(&mut self, mut line: &[u8]) -> Option<usize> {
        // A quote that is never closed ends with its line.
        self.reader.reset();
        if self.text.len() < line.len() {
            self.text.resize(line.len(), 0);
        }
        let (mut written, mut count) = (0, 0);
        loop {
            let (result, read, more_text, more_ends) = self.reader.read_record(
                line,
                self.text.get_mut(written..)?,
                self.ends.get_mut(count..)?,
            );
            line = line.get(read..)?;
            written += more_text;
            count += more_ends;
            match result {
                // Reading on where nothing is left tells the reader that the record is over.
                ReadRecordResult::InputEmpty => {}
                ReadRecordResult::Record | ReadRecordResult::End => return Some(count),
                ReadRecordResult::OutputFull | ReadRecordResult::OutputEndsFull => return None,
            }
        }
    }
}

impl<'a> Fields<'a> {
    pub(super) fn len(self) -> usize {
        self.ends.len()
    }

    /// The field at an index; empty if there is none.
    pub(super) fn get(self, index: usize) -> &'a [u8] {
        let begin = match index.checked_sub(1) {
            Some(before) => self.ends.get(before).copied(),
            None => Some(0),
        };
        let range = begin.zip(self.ends.get(index).copied());
        let field = range.and_then(|(begin, end)| self.text.get(begin..end));
        without_quotes(field.unwrap_or_default())
    }

    pub(super) fn iter(self) -> impl Iterator<Item = &'a [u8]> {
        (0..self.len()).map(move |index| self.get(index))
    }
}

fn without_quotes(field: &[u8]) -> &[u8] {
    let field = field.trim_ascii();
    match field {
        [b'"', inner @ .., b'"'] | [b'\'', inner @ .., b'\''] => inner.trim_ascii(),
        _ => field,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(delimiter: Delimiter, line: &str) -> Option<Vec<String>> {
        let mut splitter = Splitter::new(delimiter, 5);
        let fields = splitter.split(line.as_bytes())?;
        let texts = fields.iter().map(|field| field.to_vec());
        Some(texts.map(|text| String::from_utf8(text).unwrap()).collect())
    }

    #[test]
    fn the_header_tells_the_delimiter() {
        for (header, expected) in [
            ("t_s,roll_rad,pitch_rad", Delimiter::Character(b',')),
            ("t_s, roll_rad, pitch_rad", Delimiter::Character(b',')),
            ("t_s;roll (x, rad);pitch", Delimiter::Character(b';')),
            ("\"t;s;x\",roll,pitch", Delimiter::Character(b',')),
            ("t_s\troll rad\tpitch", Delimiter::Character(b'\t')),
            ("  t_s   roll_rad pitch ", Delimiter::Spaces),
            ("t_s ", Delimiter::Character(b',')),
            ("", Delimiter::Character(b',')),
        ] {
            let found = Delimiter::of_header(header.as_bytes());
            assert_eq!(found, expected, "{header:?}");
        }
    }

    #[test]
    fn quotes_and_spaces_around_fields_are_taken_off() {
        let comma = Delimiter::Character(b',');
        let expected = Some(["a", "b,c", "d", ""].map(String::from).to_vec());
        assert_eq!(split(comma, "a, \"d\""), Some(vec!["a".into(), "d".into()]));
        assert_eq!(split(comma, "  a ,\"b,c\",'d',"), expected);
        assert_eq!(
            split(Delimiter::Spaces, "  a \t 'b'   \"c\""),
            Some(["a", "b", "c"].map(String::from).to_vec())
        );
        // A quote without its partner spoils no later line.
        let mut splitter = Splitter::new(comma, 5);
        assert_eq!(splitter.split(b"1,\"2,3").unwrap().len(), 2);
        assert_eq!(splitter.split(b"1,2,3").unwrap().len(), 3);
    }

    #[test]
    fn no_more_fields_than_allowed() {
        for (delimiter, separator) in [(Delimiter::Character(b';'), ";"), (Delimiter::Spaces, "  ")]
        {
            assert_eq!(
                split(delimiter, &["1"; 5].join(separator)).unwrap().len(),
                5
            );
            assert_eq!(split(delimiter, &["1"; 6].join(separator)), None);
        }
    }
}
