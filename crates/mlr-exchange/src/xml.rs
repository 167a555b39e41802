//! Writing XML, element by element.

use std::fmt::Write;

/// A document under construction.
pub(crate) struct Writer {
    text: String,
    open: Vec<&'static str>,
}

/// Attributes of an element.
pub(crate) type Attributes<'a> = &'a [(&'a str, String)];

impl Writer {
    pub(crate) fn new(comment: &str) -> Self {
        // Two hyphens would end the comment.
        let comment = comment.replace("--", "- -");
        Self {
            text: format!("<?xml version=\"1.0\"?>\n<!-- {comment} -->\n"),
            open: Vec::new(),
        }
    }

    /// Begins an element, to be ended by [`close`](Self::close).
    pub(crate) fn open(&mut self, name: &'static str, attributes: Attributes<'_>) {
        self.tag(name, attributes, ">");
        self.open.push(name);
    }

    /// An element without content.
    pub(crate) fn empty(&mut self, name: &'static str, attributes: Attributes<'_>) {
        self.tag(name, attributes, "/>");
    }

    /// Ends the innermost element.
    pub(crate) fn close(&mut self) {
        if let Some(name) = self.open.pop() {
            self.indent();
            self.text += &format!("</{name}>\n");
        }
    }

    /// The document, all elements ended.
    pub(crate) fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.close();
        }
        self.text
    }

    fn tag(&mut self, name: &str, attributes: Attributes<'_>, end: &str) {
        self.indent();
        self.text += &format!("<{name}");
        for (key, value) in attributes {
            let _ = write!(self.text, " {key}=\"{}\"", escaped(value));
        }
        self.text += end;
        self.text.push('\n');
    }

    fn indent(&mut self) {
        self.text += &"  ".repeat(self.open.len());
    }
}

/// Characters that XML gives a meaning become entities; those that it cannot hold become spaces.
fn escaped(text: &str) -> String {
    let escape = |c: char| match c {
        '&' => "&amp;".to_string(),
        '<' => "&lt;".to_string(),
        '>' => "&gt;".to_string(),
        '"' => "&quot;".to_string(),
        c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => " ".to_string(),
        c => c.to_string(),
    };
    text.chars().map(escape).collect()
}

/// A number that reads back as the same, without a sign of zero and without what rounding left of
/// zero.
pub(crate) fn number(value: f64) -> String {
    if value.abs() < 1e-15 {
        "0".into()
    } else if value.abs() < 1e-4 {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}

/// Numbers with spaces between them.
pub(crate) fn numbers<'a>(values: impl IntoIterator<Item = &'a f64>) -> String {
    let numbers: Vec<String> = values.into_iter().map(|value| number(*value)).collect();
    numbers.join(" ")
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn whatever_a_name_holds_comes_back(name in "\\PC*", comment in "\\PC*") {
            let mut xml = Writer::new(&comment);
            xml.open("robot", &[("name", name.clone())]);
            xml.empty("link", &[]);
            let text = xml.finish();
            let document = roxmltree::Document::parse(&text).unwrap();
            prop_assert_eq!(document.root_element().attribute("name"), Some(name.as_str()));
        }

        #[test]
        fn numbers_read_back_as_the_same(value in -1e3..1e3_f64, small in -1e-6..1e-6_f64) {
            prop_assert_eq!(number(value).parse::<f64>().unwrap(), value);
            prop_assert!((number(small).parse::<f64>().unwrap() - small).abs() < 1e-15);
        }
    }
}
