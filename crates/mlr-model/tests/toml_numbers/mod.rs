//! The numbers of a TOML document by their paths, as errors name them: `legs[2].hip_m[0]`.

use toml::Value;

/// The paths of all numbers.
pub(crate) fn paths(document: &Value) -> Vec<String> {
    let mut found = Vec::new();
    collect(document, "", &mut found);
    found
}

fn collect(value: &Value, path: &str, found: &mut Vec<String>) {
    match value {
        Value::Table(table) => {
            for (key, value) in table {
                let dot = if path.is_empty() { "" } else { "." };
                collect(value, &format!("{path}{dot}{key}"), found);
            }
        }
        Value::Array(values) => {
            for (index, value) in values.iter().enumerate() {
                collect(value, &format!("{path}[{index}]"), found);
            }
        }
        Value::Float(_) | Value::Integer(_) => found.push(path.to_string()),
        _ => {}
    }
}

/// The value at a path of the document.
pub(crate) fn at<'a>(document: &'a mut Value, path: &str) -> &'a mut Value {
    path.split(['.', '['])
        .fold(document, |value, key| match key.strip_suffix(']') {
            Some(index) => &mut value[index.parse::<usize>().unwrap()],
            None => &mut value[key],
        })
}
