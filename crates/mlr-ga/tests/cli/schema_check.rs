//! JSON against a JSON Schema, as far as schemas of types go, and strictly: a key that the schema does not
//! name is an error, so that nothing is printed undescribed.

use std::collections::BTreeSet;

use serde_json::Value;

/// What does not keep to the schema, and where.
pub(crate) fn check(schema: &Value, value: &Value) -> Result<(), String> {
    Checker { root: schema }.whole(schema, value, "")
}

/// Keywords that say nothing about whether a value is valid.
const NOTES: [&str; 8] = [
    "$schema",
    "$defs",
    "title",
    "description",
    "default",
    "format",
    "writeOnly",
    "readOnly",
];

struct Checker<'s> {
    root: &'s Value,
}

impl Checker<'_> {
    /// A value of its own: all its keys must be known.
    fn whole(&self, schema: &Value, value: &Value, at: &str) -> Result<(), String> {
        let known = self.part(schema, value, at)?;
        let keys = value
            .as_object()
            .into_iter()
            .flat_map(|object| object.keys());
        match keys.into_iter().find(|key| !known.contains(*key)) {
            Some(key) => Err(format!("{at}/{key}: the schema does not name it")),
            None => Ok(()),
        }
    }

    /// One of the schemas of a value; the keys that it names.
    fn part(&self, schema: &Value, value: &Value, at: &str) -> Result<BTreeSet<String>, String> {
        let mut known = BTreeSet::new();
        let Some(keywords) = schema.as_object() else {
            return match schema {
                // Anything goes.
                Value::Bool(true) => Ok(value
                    .as_object()
                    .into_iter()
                    .flatten()
                    .map(|(key, _)| key.clone())
                    .collect()),
                _ => Err(format!("{at}: nothing is valid here")),
            };
        };
        if keywords
            .keys()
            .all(|keyword| NOTES.contains(&keyword.as_str()))
        {
            return self.part(&Value::Bool(true), value, at);
        }
        let fail = |what: &str| Err(format!("{at}: {value} is not {what}"));
        for (keyword, of) in keywords {
            let list = || of.as_array().expect("a list of schemas");
            match keyword.as_str() {
                "$ref" => {
                    let place = of.as_str().and_then(|name| name.strip_prefix('#'));
                    let schema = place.and_then(|place| self.root.pointer(place));
                    known.extend(self.part(schema.expect("a schema of that name"), value, at)?);
                }
                "const" if of != value => return fail(&of.to_string()),
                "enum" if !list().contains(value) => return fail(&format!("one of {of}")),
                "type" => {
                    let types = match of {
                        Value::Array(types) => types.clone(),
                        one => vec![one.clone()],
                    };
                    if !types.iter().any(|name| is_a(value, name.as_str().unwrap())) {
                        return fail(&of.to_string());
                    }
                }
                "minimum" if value.as_f64() < of.as_f64() => {
                    return fail(&format!("at least {of}"));
                }
                "maximum" if value.as_f64() > of.as_f64() => return fail(&format!("at most {of}")),
                "allOf" => {
                    for schema in list() {
                        known.extend(self.part(schema, value, at)?);
                    }
                }
                "oneOf" | "anyOf" => {
                    let each: Vec<_> = list()
                        .iter()
                        .map(|schema| self.part(schema, value, at))
                        .collect();
                    let valid = each.iter().filter(|result| result.is_ok()).count();
                    if valid == 0 || (keyword == "oneOf" && valid > 1) {
                        return Err(format!("{at}: {valid} alternatives fit {value}: {each:?}"));
                    }
                    known.extend(each.into_iter().flatten().flatten());
                }
                "properties" => {
                    for (key, schema) in of.as_object().unwrap() {
                        if let Some(value) = value.get(key) {
                            self.whole(schema, value, &format!("{at}/{key}"))?;
                            known.insert(key.clone());
                        }
                    }
                }
                "required" => {
                    let mut keys = list().iter().filter_map(Value::as_str);
                    if let Some(key) = keys.find(|key| value.get(key).is_none()) {
                        return Err(format!("{at}: {key} is missing"));
                    }
                }
                "additionalProperties" => {
                    let named = keywords.get("properties");
                    for (key, value) in value.as_object().into_iter().flatten() {
                        if named.is_none_or(|named| named.get(key).is_none()) {
                            self.whole(of, value, &format!("{at}/{key}"))?;
                            known.insert(key.clone());
                        }
                    }
                }
                "items" | "prefixItems" => {
                    for (index, item) in value.as_array().into_iter().flatten().enumerate() {
                        let schema = match of {
                            Value::Array(each) => each.get(index).unwrap_or(&Value::Bool(true)),
                            every => every,
                        };
                        self.whole(schema, item, &format!("{at}/{index}"))?;
                    }
                }
                "minItems" if value.as_array().map(Vec::len) < of.as_u64().map(|n| n as usize) => {
                    return fail(&format!("{of} items or more"));
                }
                "maxItems" if value.as_array().map(Vec::len) > of.as_u64().map(|n| n as usize) => {
                    return fail(&format!("{of} items or less"));
                }
                "const" | "enum" | "minimum" | "maximum" | "minItems" | "maxItems" => {}
                note if NOTES.contains(&note) => {}
                other => return Err(format!("{at}: {other:?} is a keyword that is not checked")),
            }
        }
        Ok(known)
    }
}

fn is_a(value: &Value, name: &str) -> bool {
    match name {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_u64() || value.is_i64(),
        "number" => value.is_number(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        other => panic!("{other:?} is no type"),
    }
}

#[test]
fn what_does_not_keep_to_a_schema_is_found() {
    let schema = serde_json::json!({
        "type": "object",
        "properties": {"kind": {"const": "a"}, "leg": {"$ref": "#/$defs/leg"}},
        "required": ["kind"],
        "oneOf": [{"properties": {"x": {"type": "null"}}, "required": ["x"]},
                  {"properties": {"y": {"type": ["number", "null"]}}, "required": ["y"]}],
        "$defs": {"leg": {"type": "integer", "minimum": 1, "maximum": 6}}
    });
    let told = |json: &str| check(&schema, &serde_json::from_str(json).unwrap());
    assert_eq!(told(r#"{"kind": "a", "leg": 6, "y": 0.5}"#), Ok(()));
    for (json, what) in [
        (r#"{"kind": "b", "y": 1}"#, "/kind"),
        (r#"{"y": 1}"#, "kind is missing"),
        (r#"{"kind": "a", "leg": 7, "y": 1}"#, "at most 6"),
        (r#"{"kind": "a", "leg": 1.5, "y": 1}"#, "integer"),
        (
            r#"{"kind": "a", "y": 1, "z": 2}"#,
            "/z: the schema does not name it",
        ),
        (r#"{"kind": "a"}"#, "0 alternatives"),
        (r#"{"kind": "a", "x": null, "y": null}"#, "2 alternatives"),
    ] {
        let message = told(json).unwrap_err();
        assert!(message.contains(what), "{json}: {message}");
    }
}
