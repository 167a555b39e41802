//! `mlr-ga schema` and `mlr-ga config`: what is written and what can be set, from the types.

use clap::{Args, builder::PossibleValuesParser};
use mlr_exchange::ExportedJson;
use mlr_ga::{
    CalibrationReport, Configuration, DetectionReport, DiagnosisReport, ExplanationReport,
    IdentificationReport, IdentifySettings, Method, ProbeReport, RecoveryReport, RobotCheck,
    SimulationReport, SteeringReport, documented_toml,
};
use schemars::{JsonSchema, Schema, generate::SchemaSettings};

use super::{
    compare, convert, evaluate, evaluate_discrepancy, evaluate_effects, explain_sensor,
    explain_servo, export, import, model_files::MethodName, output, report,
};

/// A schema by its name.
struct Named {
    name: &'static str,
    text: fn() -> serde_json::Result<String>,
}

/// The schema of what a command prints.
macro_rules! printed {
    ($name:literal, $type:ty) => {
        Named {
            name: $name,
            text: || of::<$type>($name, SchemaSettings::for_serialize),
        }
    };
}

/// The schema of another program, as it is kept.
macro_rules! kept {
    ($name:literal) => {
        Named {
            name: $name,
            text: || {
                Ok(
                    include_str!(concat!("../../../../docs/schemas/", $name, ".schema.json"))
                        .into(),
                )
            },
        }
    };
}

const SCHEMAS: &[Named] = &[
    printed!("calibration", CalibrationReport),
    printed!("comparison", compare::Report<'static>),
    Named {
        name: CONFIG,
        text: || of::<Configuration>(CONFIG, SchemaSettings::for_deserialize),
    },
    printed!("conversion", convert::Report<'static>),
    printed!("detection", DetectionReport),
    printed!("diagnosis", DiagnosisReport),
    printed!("discrepancy", evaluate_discrepancy::Report),
    printed!("effects-evaluation", evaluate_effects::Report),
    printed!("evaluation", evaluate::Report),
    printed!("explanation", ExplanationReport),
    printed!("export", export::Report<'static>),
    printed!("identification", IdentificationReport),
    printed!("import", import::Report<'static>),
    kept!("mlrd-config"),
    kept!("mlrd-event"),
    printed!("probe", ProbeReport),
    printed!("recovery", RecoveryReport),
    printed!("report", report::Made),
    printed!("robot", ExportedJson),
    printed!("robot-check", RobotCheck),
    printed!("sensor-explanation", explain_sensor::Report<'static>),
    printed!("sensor-transfer", explain_sensor::TransferReport<'static>),
    printed!("servo-explanation", explain_servo::Report<'static>),
    printed!("simulation", SimulationReport),
    printed!("steering", SteeringReport),
];

const CONFIG: &str = "config";

#[derive(Debug, Args)]
pub(super) struct SchemaOptions {
    /// What is described; without it, the names are listed.
    #[arg(value_name = "NAME",
          value_parser = PossibleValuesParser::new(SCHEMAS.iter().map(|schema| schema.name)))]
    name: Option<String>,
}

#[derive(Debug, Args)]
pub(super) struct ConfigOptions {
    /// The preset to print [default: mlr].
    #[arg(long, value_enum)]
    method: Option<MethodName>,
}

/// Prints a schema, or the names of all.
pub(super) fn run(options: &SchemaOptions) -> anyhow::Result<()> {
    let names = || SCHEMAS.iter().map(|schema| format!("{}\n", schema.name));
    let asked = |schema: &&Named| Some(schema.name) == options.name.as_deref();
    let text = match SCHEMAS.iter().find(asked) {
        Some(schema) => (schema.text)()?,
        None => names().collect(),
    };
    Ok(output::result(&text)?)
}

/// Prints all settings, with what they mean.
pub(super) fn print_config(options: &ConfigOptions) -> anyhow::Result<()> {
    let method = options.method.map_or(Method::default(), Method::from);
    let configuration = Configuration {
        identification: IdentifySettings::of(method),
        ..Configuration::default()
    };
    let schema = generated::<Configuration>(CONFIG, SchemaSettings::for_deserialize);
    let settings = documented_toml(&configuration, schema.as_value())?;
    Ok(output::result(&format!(
        "# All keys of --config with their defaults. A file needs only those that differ.\n\n{settings}"
    ))?)
}

/// Whether a schema is of what is read or of what is written.
type Contract = fn(SchemaSettings) -> SchemaSettings;

fn of<T: JsonSchema>(name: &str, contract: Contract) -> serde_json::Result<String> {
    Ok(serde_json::to_string_pretty(&generated::<T>(name, contract))? + "\n")
}

fn generated<T: JsonSchema>(name: &str, contract: Contract) -> Schema {
    let settings = contract(SchemaSettings::draft2020_12());
    let mut schema = settings.into_generator().into_root_schema_for::<T>();
    schema.insert("title".into(), name.into());
    schema
}

#[cfg(test)]
mod tests {
    use std::{collections::BTreeSet, fs, path::Path};

    use super::*;

    /// ```text
    /// MLR_RECORD_GOLDEN=1 cargo test -p mlr-ga schema
    /// ```
    /// writes them anew.
    #[test]
    fn the_schemas_that_are_kept_are_those_of_the_types() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/schemas");
        let of_name = |name: &str| folder.join(format!("{name}.schema.json"));
        for Named { name, text } in SCHEMAS {
            let text = text().unwrap();
            let is_own = !name.starts_with("mlrd-");
            if is_own && std::env::var_os("MLR_RECORD_GOLDEN").is_some() {
                fs::write(of_name(name), &text).unwrap();
            }
            assert!(
                fs::read_to_string(of_name(name)).unwrap() == text,
                "{name}: the type has changed; MLR_RECORD_GOLDEN=1 writes its schema anew"
            );
        }
        let kept: BTreeSet<_> = fs::read_dir(&folder)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .collect();
        let named: BTreeSet<_> = SCHEMAS.iter().map(|schema| of_name(schema.name)).collect();
        assert_eq!(kept, named);
    }
}
