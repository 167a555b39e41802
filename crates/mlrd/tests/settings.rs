//! Every number of the daemon's own settings is checked, and refused by its name. Those
//! that it shares with the command line are checked in mlr-ga.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use mlr_ga::ConfigurationError;
use mlrd::Settings;
use toml::{Table, Value};

/// Sections that the command line shares.
const SHARED: [&str; 4] = ["full_scale", "identification", "mounting", "explanation"];

/// The daemon's own numbers, as key and section.
fn own_numbers() -> Vec<(Option<&'static str>, String, bool)> {
    let settings = Settings {
        threads: Some(1),
        ..Settings::default()
    };
    let mut all = Table::try_from(settings).unwrap();
    let of_section = |all: &mut Table, name: &'static str| {
        let Some(Value::Table(section)) = all.remove(name) else {
            panic!("{name} has a section");
        };
        section.into_iter().map(move |entry| (Some(name), entry))
    };
    let (of_record, of_learning) = (
        of_section(&mut all, "record"),
        of_section(&mut all, "learning"),
    );
    all.retain(|key, _| !SHARED.contains(&key));
    let at_the_top = all.into_iter().map(|entry| (None, entry));
    at_the_top
        .chain(of_record)
        .chain(of_learning)
        .filter(|(_, (_, value))| value.is_integer() || value.is_float())
        .map(|(section, (key, value))| (section, key, value.is_integer()))
        .collect()
}

#[test]
fn every_number_is_accepted_with_sense_or_refused_by_name() {
    let numbers = own_numbers();
    let keys: Vec<&str> = numbers.iter().map(|(_, key, _)| key.as_str()).collect();
    for key in [
        "baud",
        "threads",
        "seed",
        "i2c_rate_hz",
        "status_every_s",
        "file_mb",
        "walk_s",
        "reference_walks",
    ] {
        assert!(keys.contains(&key), "{key} is not among {keys:?}");
    }
    for (section, key, is_whole) in numbers {
        for number in [
            "nan",
            "inf",
            "-inf",
            "1e300",
            "-1",
            "0",
            "9223372036854775807",
        ] {
            let number = match is_whole || number.contains(['n', 'e']) {
                true => number.to_string(),
                false => format!("{number}.0"),
            };
            let header = section.map_or(String::new(), |name| format!("[{name}]\n"));
            let text = format!("{header}{key} = {number}\n");
            match Settings::checked_from_toml(&text, None) {
                // Zero is a seed like any other.
                Ok(_) => assert_eq!((key.as_str(), number.as_str()), ("seed", "0")),
                Err(ConfigurationError::Setting(error)) => {
                    let dot = section.map_or(String::new(), |name| format!("{name}."));
                    assert_eq!(error.name, format!("{dot}{key}"), "{text}");
                    assert!(error.line.is_some(), "{error}");
                }
                // Not even a number of the right kind: shown where it stands.
                Err(ConfigurationError::Syntax(error)) => {
                    assert!(error.to_string().contains(&key), "{error}");
                }
            }
        }
    }
}
