use mlr_filter::SettingError;
use toml::de::{DeTable, DeValue};

/// The error with the line of the TOML text at which its setting stands, where the text
/// names it.
pub fn located(mut error: SettingError, text: &str) -> SettingError {
    error.line = line_of(&error.name, text);
    error
}

/// The line, from 1, of the value at a path like `legs[2].hip_m[0]`.
fn line_of(name: &str, text: &str) -> Option<usize> {
    let document = DeTable::parse(text).ok()?;
    let mut start = 0;
    let mut value = DeValue::Table(document.into_inner());
    for key in name.split(['.', '[']) {
        let found = match key.strip_suffix(']') {
            Some(index) => value.get(index.parse::<usize>().ok()?)?,
            None => value.get(key)?,
        };
        start = found.span().start;
        value = found.get_ref().clone();
    }
    Some(text.get(..start)?.matches('\n').count() + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "a = 1\n[b]\nc = [1,\n  2]\n\n[[d]]\ne = 1\n[[d]]\ne = { f = 2 }\n";

    #[test]
    fn values_are_found_in_sections_and_lists() {
        for (name, line) in [
            ("a", Some(1)),
            ("b.c", Some(3)),
            ("b.c[1]", Some(4)),
            ("d[0].e", Some(7)),
            ("d[1].e.f", Some(9)),
            ("d[2].e", None),
            ("b.x", None),
            ("", None),
            ("b..c", None),
        ] {
            assert_eq!(line_of(name, TEXT), line, "{name}");
        }
    }

    #[test]
    fn the_line_is_told() {
        let error = located(SettingError::new("b.c[1]", 2, "3"), TEXT);
        assert_eq!(
            error.to_string(),
            "line 4: b.c[1]: 2 is not valid, expected 3"
        );
    }
}
