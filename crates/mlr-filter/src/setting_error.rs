use std::{fmt::Display, ops::RangeInclusive};

use thiserror::Error;

/// A setting that makes no sense, by its name in the configuration file.
///
/// ```
/// use mlr_filter::SettingError;
///
/// let error = SettingError::check("window_s", -1.0, 0.5..=600.0, "s").unwrap_err();
/// let error = error.under("detector").under("identification");
/// assert_eq!(
///     error.to_string(),
///     "identification.detector.window_s: -1 is not valid, expected 0.5 to 600 s"
/// );
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{}{name}: {value} is not valid, expected {expected}", self.place())]
pub struct SettingError {
    /// Dotted path of the setting, as in `detector.window_s` or `variations[3].friction`;
    /// or the option that set it, as in `--window-s`.
    pub name: String,
    /// What was given.
    pub value: String,
    /// What was expected, with the unit.
    pub expected: String,
    /// Line of the file that the setting was read from, where that is known.
    pub line: Option<usize>,
}

impl SettingError {
    /// An error for any kind of value.
    pub fn new(name: impl Into<String>, value: impl Display, expected: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            value: value.to_string(),
            expected: expected.into(),
            line: None,
        }
    }

    /// Checks that a number lies within its bounds, which NaN never does. The `unit` may be
    /// empty.
    ///
    /// # Errors
    /// When it does not.
    pub fn check<T: PartialOrd + Display>(
        name: impl Into<String>,
        value: T,
        bounds: RangeInclusive<T>,
        unit: &str,
    ) -> Result<(), Self> {
        if bounds.contains(&value) {
            return Ok(());
        }
        let expected = format!("{} to {} {unit}", bounds.start(), bounds.end());
        Err(Self::new(name, value, expected.trim_end()))
    }

    /// Checks every number of a list; the error names its index, from 0.
    ///
    /// # Errors
    /// For the first that does not lie within the bounds.
    pub fn check_each<'a>(
        name: &str,
        values: impl IntoIterator<Item = &'a f64>,
        bounds: RangeInclusive<f64>,
        unit: &str,
    ) -> Result<(), Self> {
        let mut numbered = values.into_iter().enumerate();
        numbered.try_for_each(|(index, value)| {
            Self::check(format!("{name}[{index}]"), *value, bounds.clone(), unit)
        })
    }

    /// The same setting as seen from the section that holds it.
    #[must_use]
    pub fn under(mut self, section: &str) -> Self {
        self.name = format!("{section}.{}", self.name);
        self
    }

    /// The same setting by the option that set it: `options` pairs names of settings with
    /// options.
    #[must_use]
    pub fn as_option(mut self, options: &[(&str, &str)]) -> Self {
        if let Some((_, option)) = options.iter().find(|(name, _)| *name == self.name) {
            self.name = (*option).to_string();
        }
        self
    }

    fn place(&self) -> String {
        self.line
            .map_or(String::new(), |line| format!("line {line}: "))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn what_is_no_number_is_within_no_bounds() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let error = SettingError::check("x", value, f64::MIN..=f64::MAX, "").unwrap_err();
            assert_eq!(error.value, value.to_string());
        }
    }

    #[test]
    fn an_option_takes_the_place_of_its_setting_only() {
        let options = [("window_s", "--window-s")];
        let named = |name: &str| SettingError::new(name, 0, "more").as_option(&options).name;
        assert_eq!(named("window_s"), "--window-s");
        assert_eq!(named("detector.window_s"), "detector.window_s");
    }

    #[test]
    fn the_place_in_a_list_is_named() {
        let error = SettingError::check_each("deg", &[0.5, 2.0], 0.0..=1.0, "").unwrap_err();
        assert_eq!(error.to_string(), "deg[1]: 2 is not valid, expected 0 to 1");
    }

    proptest! {
        #[test]
        fn exactly_the_numbers_between_the_bounds_pass(value in -10.0..10.0_f64, low in -5.0..0.0_f64) {
            let passes = SettingError::check("x", value, low..=1.0, "m").is_ok();
            prop_assert_eq!(passes, value >= low && value <= 1.0);
        }
    }
}
