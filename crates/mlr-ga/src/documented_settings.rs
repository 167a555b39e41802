//! Settings as a file in TOML that says what each key means.

use serde::Serialize;
use serde_json::{Map, Value};

/// Longest line of a comment.
const COLUMNS: usize = 100;

/// The settings in TOML, every key below what its schema says of it: the doc comments of the types.
///
/// Keys without a value stand behind a `#`. Of several tables of one list, the first is explained.
///
/// # Errors
/// When TOML cannot express the settings.
pub fn documented_toml(
    settings: &impl Serialize,
    schema: &Value,
) -> Result<String, toml::ser::Error> {
    let values = toml::Table::try_from(settings)?;
    let mut document = Document {
        root: schema,
        text: String::new(),
    };
    document.unset(&[], &values);
    let mut table = Place::default();
    for line in toml::to_string(settings)?.lines() {
        if let Some(header) = line.strip_prefix('[') {
            let list = header.starts_with('[');
            let path: Vec<&str> = header.trim_matches(['[', ']']).split('.').collect();
            let is_repeated = list && table.path == path;
            if !is_repeated {
                document.comment(&path);
            } else {
                document.text += "\n";
            }
            document.text += &format!("{line}\n");
            if !is_repeated && let Some(values) = table_at(&values, &path) {
                document.unset(&path, values);
            }
            table = Place {
                path: path.into_iter().map(Into::into).collect(),
                is_repeated,
            };
        } else if let Some((key, _)) = line.split_once(" = ") {
            if !table.is_repeated {
                let path = table.path.iter().map(String::as_str).chain([key]);
                document.comment(&path.collect::<Vec<_>>());
            }
            document.text += &format!("{line}\n");
        }
    }
    Ok(document.text.trim_start().to_string())
}

/// The table whose keys follow.
#[derive(Default)]
struct Place {
    path: Vec<String>,
    /// Whether one like it has been explained.
    is_repeated: bool,
}

fn table_at<'v>(values: &'v toml::Table, path: &[&str]) -> Option<&'v toml::Table> {
    let mut table = values;
    for key in path {
        table = match table.get(*key)? {
            toml::Value::Table(table) => table,
            toml::Value::Array(tables) => tables.first()?.as_table()?,
            _ => return None,
        };
    }
    Some(table)
}

struct Document<'s> {
    root: &'s Value,
    text: String,
}

impl<'s> Document<'s> {
    /// Says what a key means.
    fn comment(&mut self, path: &[&str]) {
        self.text += "\n";
        if let Some(schema) = self.schema(path) {
            self.describe(schema);
        }
    }

    fn describe(&mut self, schema: &Value) {
        for line in wrapped(&self.meaning(schema)) {
            self.text += &format!("# {line}\n");
        }
    }

    /// The keys of a table that have no value, each behind a `#`.
    fn unset(&mut self, path: &[&str], values: &toml::Table) {
        let Some(schema) = self.schema(path) else {
            return;
        };
        for (key, property) in self.properties(schema) {
            if !values.contains_key(key) {
                self.unset_key(path, key, property);
            }
        }
    }

    fn unset_key(&mut self, path: &[&str], key: &str, property: &'s Value) {
        self.text += "\n";
        self.describe(property);
        let properties = self.properties(property);
        if properties.is_empty() {
            self.text += &format!("# {key} =\n");
            return;
        }
        let path: Vec<&str> = path.iter().copied().chain([key]).collect();
        self.text += &format!("# [{}]\n", path.join("."));
        for (key, property) in properties {
            self.unset_key(&path, key, property);
        }
    }

    fn schema(&self, path: &[&str]) -> Option<&'s Value> {
        path.iter().try_fold(self.root, |schema, key| {
            Some(
                self.properties(schema)
                    .into_iter()
                    .find(|(name, _)| name == key)?
                    .1,
            )
        })
    }

    fn properties(&self, schema: &'s Value) -> Vec<(&'s str, &'s Value)> {
        let schema = self.resolved(schema);
        let schema = schema
            .get("items")
            .map_or(schema, |items| self.resolved(items));
        let properties = schema.get("properties").and_then(Value::as_object);
        let all = properties.into_iter().flat_map(Map::iter);
        all.map(|(key, property)| (key.as_str(), property))
            .collect()
    }

    /// What a reference refers to; of a value that may be absent, the value.
    fn resolved(&self, schema: &'s Value) -> &'s Value {
        let of_reference = schema["$ref"]
            .as_str()
            .and_then(|name| self.root.pointer(name.strip_prefix('#')?));
        let present = || {
            let mut any = schema["anyOf"].as_array()?.iter();
            any.find(|schema| schema["type"] != "null")
        };
        match of_reference.or_else(present) {
            Some(inner) => self.resolved(inner),
            None => schema,
        }
    }

    /// The doc comment, and the values of which one is expected.
    fn meaning(&self, schema: &'s Value) -> String {
        let text = |schema: &'s Value| schema["description"].as_str().unwrap_or_default();
        let resolved = self.resolved(schema);
        let mut meaning = match text(schema) {
            "" => text(resolved).to_string(),
            own => own.to_string(),
        };
        let choices = resolved["oneOf"].as_array().into_iter().flatten();
        let mut listed = Vec::new();
        for choice in choices {
            let values = choice["enum"].as_array().into_iter().flatten();
            let values = values.chain(choice.get("const")).map(Value::to_string);
            // A choice with a number of its own.
            let keyed = choice["properties"]
                .as_object()
                .into_iter()
                .flat_map(Map::keys);
            let keyed = keyed.map(|key| format!("{{ {key} = … }}"));
            listed.extend(values.chain(keyed).map(|value| {
                let of_value = text(choice).trim_end_matches('.');
                match of_value.is_empty() {
                    true => value,
                    false => format!("{value} ({of_value})"),
                }
            }));
        }
        if !listed.is_empty() {
            meaning += &format!("\n\nOne of {}.", listed.join(", "));
        }
        meaning
    }
}

/// Paragraphs in lines of a comment; links to items become their names.
fn wrapped(text: &str) -> Vec<String> {
    let text = text.replace("[`", "`").replace("`]", "`");
    let mut lines = Vec::new();
    for paragraph in text.split("\n\n").filter(|paragraph| !paragraph.is_empty()) {
        let mut line = String::new();
        for word in paragraph.split_whitespace() {
            let is_full = line.chars().count() + word.chars().count() > COLUMNS - 3;
            if is_full && !line.is_empty() {
                lines.push(std::mem::take(&mut line));
            }
            if !line.is_empty() {
                line.push(' ');
            }
            line += word;
        }
        lines.push(line);
    }
    lines
}
