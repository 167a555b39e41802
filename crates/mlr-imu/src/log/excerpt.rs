//! Texts of a file within messages: no more of them than a person reads.

/// Characters of one text.
const MAX_CHARACTERS: usize = 60;
/// Names of a list.
const MAX_NAMES: usize = 16;

/// The beginning of a text.
pub(super) fn shortened(text: &str) -> String {
    match text.char_indices().nth(MAX_CHARACTERS) {
        None => text.into(),
        Some((end, _)) => {
            let (shown, rest) = text.split_at(end);
            format!("{shown}… ({} more)", rest.chars().count())
        }
    }
}

/// The first names of a list.
pub(super) fn listed<'a>(names: impl ExactSizeIterator<Item = &'a str>) -> String {
    let more = names.len().saturating_sub(MAX_NAMES);
    let shown: Vec<String> = names.take(MAX_NAMES).map(shortened).collect();
    let mut text = shown.join(", ");
    if more > 0 {
        text += &format!(", … ({more} more)");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_and_lists_say_how_much_is_not_shown() {
        assert_eq!(shortened("roll"), "roll");
        let long = "ä".repeat(100);
        let shown = shortened(&long);
        assert!(
            shown.starts_with('ä') && shown.ends_with("… (40 more)"),
            "{shown}"
        );
        assert_eq!(listed(["a", "b"].into_iter()), "a, b");
        let list = listed(vec![long.as_str(); 1000].into_iter());
        assert!(
            list.ends_with("… (984 more)") && list.chars().count() < 1300,
            "{list}"
        );
    }
}
