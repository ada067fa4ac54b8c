//! `docs/outcomes.md`: the keys of every verb's outcome, made from the types.

use std::fmt::Write;

use hysteron_base::json::Value;
use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema, SchemaGenerator};

use crate::{arm, arm_figures, check, command, evaluate, generate, mesh, record, rig, run, target, track};

/// A verb as it is typed, and the schema of its outcome.
type Verb = (&'static str, fn(&mut SchemaGenerator) -> Schema);

/// All verbs whose outcome has a type, in the order of the document.
const VERBS: [Verb; 19] = [
    ("simulate, reach", <run::Outcome as JsonSchema>::json_schema),
    ("record", <record::Outcome as JsonSchema>::json_schema),
    ("generate", <generate::Outcome as JsonSchema>::json_schema),
    ("command", <command::Outcome as JsonSchema>::json_schema),
    ("track", <track::Outcome as JsonSchema>::json_schema),
    ("evaluate", <evaluate::Outcome as JsonSchema>::json_schema),
    ("target", <target::Outcome as JsonSchema>::json_schema),
    ("mesh", <mesh::Outcome as JsonSchema>::json_schema),
    ("check", <check::Outcome as JsonSchema>::json_schema),
    ("rig check", <rig::check::Outcome as JsonSchema>::json_schema),
    ("rig calibrate", <rig::calibrate::Outcome as JsonSchema>::json_schema),
    ("rig emulate", <rig::emulate::Outcome as JsonSchema>::json_schema),
    ("rig recover", <rig::recover::Outcome as JsonSchema>::json_schema),
    ("arm info, arm check", <arm::info::Outcome as JsonSchema>::json_schema),
    ("arm dynamics", <arm::dynamics::Outcome as JsonSchema>::json_schema),
    ("arm simulate", <arm_figures::Outcome as JsonSchema>::json_schema),
    ("arm record", <arm::record::Outcome as JsonSchema>::json_schema),
    ("arm emulate", <arm::emulate::Outcome as JsonSchema>::json_schema),
    ("arm export", <arm::export::Outcome as JsonSchema>::json_schema),
];

const HEAD: &str = "\
# Outcomes of verbs

Every verb returns one object. `--json` prints it; verbs that write a report store the same object as `metrics.json` beside
`report.html`, and the page shows its numbers. Keys end in their unit; a key without a unit is a count, a text or a ratio. A number
that is not finite is the text `\"NaN\"`, `\"Infinity\"` or `\"-Infinity\"`. A key that is marked *optional* is left out where it does
not apply. This page is made from the program's types: `cargo run --release -p hysteron-workflow --example outcomes > docs/outcomes.md`.
";

/// The document.
pub fn document() -> String {
    let mut generator = SchemaSettings::draft2020_12().into_generator();
    let mut text = HEAD.to_owned();
    for (verb, schema) in VERBS {
        let schema = schema(&mut generator);
        section(&mut text, &format!("## `{}`", verb.replace(", ", "`, `")), schema.as_value());
    }
    text.push_str("\n# Parts of outcomes\n");
    for (name, schema) in generator.definitions() {
        section(&mut text, &format!("## {name}"), schema);
    }
    text
}

/// A heading, the description of a type and a row for each of its keys.
fn section(text: &mut String, heading: &str, schema: &Value) {
    // Writing to a string does not fail.
    let _ = write!(text, "\n{heading}\n");
    if let Some(description) = description(schema) {
        let _ = write!(text, "\n{description}\n");
    }
    let keys = keys(schema);
    if keys.is_empty() {
        let _ = write!(text, "\n{}\n", kind(schema));
        return;
    }
    text.push_str("\n| key | type | meaning |\n|---|---|---|\n");
    for (key, schema, is_optional) in keys {
        let optional = if is_optional { ", *optional*" } else { "" };
        let meaning = description(schema).unwrap_or_default();
        let _ = writeln!(text, "| `{key}` | {}{optional} | {meaning} |", kind(schema));
    }
}

/// The keys of an object, each with its schema and whether it may be missing.
fn keys(schema: &Value) -> Vec<(&str, &Value, bool)> {
    let Some(properties) = schema["properties"].as_object() else { return Vec::new() };
    let is_required =
        |key: &str| schema["required"].as_array().is_some_and(|all| all.iter().any(|one| one == key));
    properties.iter().map(|(key, schema)| (key.as_str(), schema, !is_required(key))).collect()
}

fn description(schema: &Value) -> Option<String> {
    schema["description"]
        .as_str()
        .map(|text| text.split_whitespace().collect::<Vec<_>>().join(" ").replace('|', "\\|"))
}

/// A type in words, with links to types that have a section of their own.
fn kind(schema: &Value) -> String {
    if let Some(name) = schema["$ref"].as_str().and_then(|path| path.rsplit('/').next()) {
        return format!("[{name}](#{})", name.to_lowercase());
    }
    if let Some(constant) = schema["const"].as_str() {
        return format!("`\"{constant}\"`");
    }
    if let Some(values) = schema["enum"].as_array() {
        let texts: Vec<String> =
            values.iter().filter_map(Value::as_str).map(|text| format!("`\"{text}\"`")).collect();
        return texts.join(" or ");
    }
    for several in ["oneOf", "anyOf", "allOf"] {
        if let Some(schemas) = schema[several].as_array() {
            return schemas.iter().map(kind).collect::<Vec<_>>().join(" or ");
        }
    }
    match &schema["type"] {
        Value::Array(kinds) => kinds
            .iter()
            .filter_map(Value::as_str)
            .map(|kind| one_kind(kind, schema))
            .collect::<Vec<_>>()
            .join(" or "),
        Value::String(kind) => one_kind(kind, schema),
        _ => "any".to_owned(),
    }
}

fn one_kind(kind: &str, schema: &Value) -> String {
    match kind {
        "array" => {
            let item = self::kind(&schema["items"]);
            match schema["maxItems"].as_u64() {
                Some(n) => format!("{n} × {item}"),
                None => format!("list of {item}"),
            }
        }
        "object" => match keys(schema)[..] {
            // A variant with content, as serde writes it.
            [(key, content, _)] => format!("`{{\"{key}\": …}}` with {}", self::kind(content)),
            [] => format!("map to {}", self::kind(&schema["additionalProperties"])),
            _ => "object".to_owned(),
        },
        "null" => "`null`".to_owned(),
        other => other.to_owned(),
    }
}
