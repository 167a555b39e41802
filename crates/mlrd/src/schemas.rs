//! The JSON Schemas of events and settings are those of the types.

use std::{fs, path::Path};

use schemars::{JsonSchema, generate::SchemaSettings};

use crate::{Settings, event::Event};

/// ```text
/// MLR_RECORD_GOLDEN=1 cargo test -p mlrd schemas
/// ```
/// writes it anew.
fn check<T: JsonSchema>(name: &str, contract: fn(SchemaSettings) -> SchemaSettings) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join(format!("../../docs/schemas/{name}.schema.json"));
    let settings = contract(SchemaSettings::draft2020_12());
    let mut schema = settings.into_generator().into_root_schema_for::<T>();
    schema.insert("title".into(), name.into());
    let text = serde_json::to_string_pretty(&schema).unwrap() + "\n";
    if std::env::var_os("MLR_RECORD_GOLDEN").is_some() {
        fs::write(&path, &text).unwrap();
    }
    assert!(
        fs::read_to_string(&path).unwrap() == text,
        "{name}: the type has changed; MLR_RECORD_GOLDEN=1 writes its schema anew"
    );
}

#[test]
fn the_schemas_that_are_kept_are_those_of_the_types() {
    check::<Event<'static>>("mlrd-event", SchemaSettings::for_serialize);
    check::<Settings>("mlrd-config", SchemaSettings::for_deserialize);
}
