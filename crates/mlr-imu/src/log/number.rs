//! Numbers with a decimal point or a decimal comma.

/// Reads the numbers of a log, and finds out whether it is written with decimal commas.
#[derive(Debug, Clone, Copy)]
pub(super) struct Numbers {
    separator: Separator,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Separator {
    /// A comma separates the fields.
    OnlyPoint,
    /// There were only whole numbers so far.
    Unknown,
    Point,
    Comma {
        /// Whether a number was seen whose comma cannot group thousands, as that of 1,234 can.
        is_certain: bool,
    },
}

impl Numbers {
    pub(super) fn new(may_have_commas: bool) -> Self {
        let separator = if may_have_commas {
            Separator::Unknown
        } else {
            Separator::OnlyPoint
        };
        Self { separator }
    }

    /// The finite number that a field holds.
    pub(super) fn parse(&mut self, field: &[u8]) -> Option<f64> {
        let text = str::from_utf8(field).ok()?;
        if self.separator == Separator::OnlyPoint {
            return finite(text);
        }
        match (text.contains('.'), text.contains(',')) {
            (false, false) => finite(text),
            (true, true) => None,
            (true, false) => {
                if matches!(self.separator, Separator::Comma { .. }) {
                    return None;
                }
                let number = finite(text)?;
                self.separator = Separator::Point;
                Some(number)
            }
            (false, true) => {
                let known = match self.separator {
                    Separator::Point | Separator::OnlyPoint => return None,
                    Separator::Unknown => false,
                    Separator::Comma { is_certain } => is_certain,
                };
                // More than one comma leaves more than one point, which is no number.
                let number = finite(&text.replace(',', "."))?;
                let is_certain = known || !may_group_thousands(text);
                self.separator = Separator::Comma { is_certain };
                Some(number)
            }
        }
    }

    /// Whether decimal commas were seen: if so, whether they can be nothing else.
    pub(super) fn decimal_commas(self) -> Option<bool> {
        match self.separator {
            Separator::Comma { is_certain } => Some(is_certain),
            _ => None,
        }
    }
}

fn finite(text: &str) -> Option<f64> {
    let number = text.parse::<f64>().ok();
    number.filter(|number| number.is_finite())
}

/// Whether the text, which has one comma and is a number, could be `1,234` for 1234.
fn may_group_thousands(text: &str) -> bool {
    let digits = text.trim_start_matches(['+', '-']);
    digits.split_once(',').is_some_and(|(before, after)| {
        (1..=3).contains(&before.len()) && !before.starts_with('0') && after.len() == 3
    })
}

/// How many digits a number has behind its point or comma.
pub(super) fn decimals(field: &[u8]) -> usize {
    let point = field.iter().rposition(|byte| matches!(byte, b'.' | b','));
    point.map_or(0, |point| field.len() - point - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(fields: &[&str]) -> (Vec<Option<f64>>, Option<bool>) {
        let mut numbers = Numbers::new(true);
        let parsed = fields.iter().map(|field| numbers.parse(field.as_bytes()));
        (parsed.collect(), numbers.decimal_commas())
    }

    #[test]
    fn one_kind_of_decimals_in_a_log() {
        let (values, commas) = parse(&["5", "-0,125", "1,234", "2,5e-3"]);
        assert_eq!(values, [Some(5.0), Some(-0.125), Some(1.234), Some(2.5e-3)]);
        assert_eq!(commas, Some(true));
        // After the first, the other kind is no number.
        assert_eq!(parse(&["0,5", "0.5"]).0, [Some(0.5), None]);
        assert_eq!(parse(&["0.5", "0,5"]).0, [Some(0.5), None]);
        assert_eq!(parse(&["1.234,5", "1,234,567"]).0, [None, None]);
        assert_eq!(parse(&["1.5", "2"]).1, None);
    }

    #[test]
    fn what_may_be_thousands_is_not_certain() {
        assert_eq!(parse(&["1,234", "-12,345"]).1, Some(false));
        assert_eq!(parse(&["1,234", "0,345"]).1, Some(true));
        assert_eq!(parse(&["1,234", "1,23"]).1, Some(true));
    }

    #[test]
    fn between_commas_there_are_points_only() {
        let mut numbers = Numbers::new(false);
        assert_eq!(numbers.parse(b"0,5"), None);
        assert_eq!(numbers.parse(b"0.5"), Some(0.5));
        for text in ["", "NaN", "inf", "1e999", "0x10", "\u{ff11}"] {
            assert_eq!(numbers.parse(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn decimals_are_counted() {
        assert_eq!(decimals(b"-0.125"), 3);
        assert_eq!(decimals(b"0,1"), 1);
        assert_eq!(decimals(b"12"), 0);
    }
}
