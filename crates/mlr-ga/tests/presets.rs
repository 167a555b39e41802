//! The table in docs/decision.md of what differs between the presets of the two methods.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::{collections::BTreeMap, fs, path::Path};

use mlr_ga::{IdentifySettings, Method};
use serde_json::Value;

/// Every value by its key in a configuration file; a list is one value.
fn values(settings: &IdentifySettings) -> BTreeMap<String, String> {
    fn collect(key: &str, value: &Value, values: &mut BTreeMap<String, String>) {
        match value {
            Value::Object(fields) => {
                for (name, value) in fields {
                    let key = [key, name].join(".").trim_start_matches('.').to_string();
                    collect(&key, value, values);
                }
            }
            // The list of variations is too long for a table.
            Value::Array(list) if key == "variations" => {
                values.insert(key.into(), format!("{} of them", list.len()));
            }
            Value::Null => {
                values.insert(key.into(), "-".into());
            }
            Value::String(text) => {
                values.insert(key.into(), text.clone());
            }
            other => {
                values.insert(key.into(), other.to_string());
            }
        }
    }
    let mut found = BTreeMap::new();
    collect("", &serde_json::to_value(settings).unwrap(), &mut found);
    found
}

/// Setting, mlr, paper of each row of the table under the heading.
fn documented() -> Vec<[String; 3]> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/decision.md");
    let text = fs::read_to_string(path).unwrap();
    let (_, section) = text.split_once("## The two methods").unwrap();
    let section = section.split("\n## ").next().unwrap();
    section
        .lines()
        .filter(|line| line.starts_with("| `"))
        .map(|line| {
            let cells: Vec<&str> = line.split('|').map(str::trim).collect();
            assert!(
                cells.len() == 6 && !cells[4].is_empty(),
                "no reason: {line}"
            );
            [cells[1], cells[2], cells[3]].map(|cell| cell.trim_matches('`').to_string())
        })
        .collect()
}

#[test]
fn every_difference_between_the_presets_is_documented_and_no_other() {
    let [mlr, paper] =
        [Method::Mlr, Method::Paper].map(|method| values(&IdentifySettings::of(method)));
    let mut differences: Vec<[String; 3]> = mlr
        .iter()
        .filter(|(key, value)| paper[*key] != **value)
        .map(|(key, value)| [key.clone(), value.clone(), paper[key].clone()])
        .collect();
    assert_eq!(mlr.len(), paper.len());
    let mut documented = documented();
    differences.sort();
    documented.sort();
    assert_eq!(differences, documented);
}
