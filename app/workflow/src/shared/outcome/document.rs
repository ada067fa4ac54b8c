//! The keys of outcomes, made from the types: the second half of `docs/outcomes.md`.
//!
//! A schema is JSON, and schemars has no types for its contents: the functions below take its parts as values.

use std::fmt::Write;

use hysteron_base::json::{self, Value};
use schemars::generate::SchemaSettings;
use schemars::{Schema, SchemaGenerator};

use super::Outcome;
use crate::tendon::{
    adapt, check, command, evaluate, fit_material, fit_residual, fit_sensor, generate, identify, mesh,
    reduce, sense, shards, target, track, train,
};
use crate::{arm, import, rig, rig::record, shared::run};

/// A verb and the type of its outcome.
#[derive(Debug)]
pub struct VerbOutcome {
    /// As it is typed; several verbs may have one outcome.
    names: &'static [&'static str],
    schema: fn(&mut SchemaGenerator) -> Schema,
    /// Reads an outcome and writes it again.
    rewrite: fn(&str) -> Result<String, json::Error>,
}

/// The outcome `T` of the verbs of these names.
pub const fn verb<T: Outcome>(names: &'static [&'static str]) -> VerbOutcome {
    VerbOutcome { names, schema: T::json_schema, rewrite: |text| json::to_text(json::from_text::<T>(text)?) }
}

impl VerbOutcome {
    /// The verbs, as they are typed.
    pub fn names(&self) -> &'static [&'static str] {
        self.names
    }

    /// The schema of their outcome; its parts are added to the generator.
    pub fn schema(&self, generator: &mut SchemaGenerator) -> Schema {
        (self.schema)(generator)
    }
}

/// All verbs whose outcome has a type, in the order of the document.
pub static VERBS: [VerbOutcome; 44] = [
    verb::<run::Outcome>(&["simulate", "reach"]),
    verb::<record::Outcome>(&["record"]),
    verb::<generate::Outcome>(&["generate"]),
    verb::<shards::plan::Outcome>(&["shards plan"]),
    verb::<shards::work::Outcome>(&["shards work"]),
    verb::<shards::status::Outcome>(&["shards status"]),
    verb::<shards::merge::Outcome>(&["shards merge"]),
    verb::<command::Outcome>(&["command"]),
    verb::<track::Outcome>(&["track"]),
    verb::<evaluate::Outcome>(&["evaluate"]),
    verb::<target::Outcome>(&["target"]),
    verb::<mesh::Outcome>(&["mesh"]),
    verb::<reduce::Outcome>(&["reduce"]),
    verb::<check::Outcome>(&["check"]),
    verb::<import::Outcome>(&["import"]),
    verb::<fit_material::Outcome>(&["fit-material"]),
    verb::<identify::Outcome>(&["identify"]),
    verb::<fit_residual::Outcome>(&["fit-residual"]),
    verb::<adapt::Outcome>(&["adapt"]),
    verb::<train::Outcome>(&["train"]),
    verb::<fit_sensor::Outcome>(&["fit-sensor"]),
    verb::<sense::Outcome>(&["sense"]),
    verb::<rig::check::Outcome>(&["rig check"]),
    verb::<rig::calibrate::Outcome>(&["rig calibrate"]),
    verb::<rig::emulate::Outcome>(&["rig emulate"]),
    verb::<rig::recover::Outcome>(&["rig recover"]),
    verb::<rig::identify_servo::Outcome>(&["identify-servo"]),
    verb::<arm::info::Outcome>(&["arm info", "arm check"]),
    verb::<arm::dynamics::Outcome>(&["arm dynamics"]),
    verb::<arm::excite::Outcome>(&["arm excite"]),
    verb::<arm::simulate::Outcome>(&["arm simulate"]),
    verb::<arm::record::Outcome>(&["arm record"]),
    verb::<arm::emulate::Outcome>(&["arm emulate"]),
    verb::<arm::export::Outcome>(&["arm export"]),
    verb::<arm::generate::Outcome>(&["arm generate"]),
    verb::<arm::identify::inertia::Outcome>(&["arm identify inertia"]),
    verb::<arm::identify::friction::Outcome>(&["arm identify friction"]),
    verb::<arm::identify::servo::Outcome>(&["arm identify servo"]),
    verb::<arm::identify::payload::Outcome>(&["arm identify payload"]),
    verb::<arm::fit::delan::Outcome>(&["arm fit delan"]),
    verb::<arm::fit::neural::Outcome>(&["arm fit neural"]),
    verb::<arm::adapt::Outcome>(&["arm adapt"]),
    verb::<arm::evaluate::Outcome>(&["arm evaluate"]),
    verb::<arm::estimate::Outcome>(&["arm estimate"]),
];

/// The outcome of a verb read from JSON and written again; `None` for a verb whose outcome has no type.
///
/// # Errors
/// Those of reading and writing JSON.
// Inlined, so that the readers of all outcomes are built where they are used: in tests, not in the program.
#[inline]
pub fn rewrite(verb: &str, text: &str) -> Option<Result<String, json::Error>> {
    VERBS.iter().find(|one| one.names.contains(&verb)).map(|one| (one.rewrite)(text))
}

/// Line of `docs/outcomes.md` below which all is made from the types.
pub const MARK: &str =
    "<!-- Below: made by `cargo run --release -p hysteron-studies --example outcomes`. -->\n";

/// The keys of the outcomes of these verbs, as Markdown.
pub fn document<'a>(verbs: impl IntoIterator<Item = &'a VerbOutcome>) -> String {
    let mut generator = SchemaSettings::draft2020_12().into_generator();
    let mut text =
        "\n## Keys of each verb\n\nA key that is *optional* is absent where it does not apply.\n".to_owned();
    for verb in verbs {
        let schema = (verb.schema)(&mut generator);
        section(&mut text, &format!("### `{}`", verb.names.join("`, `")), schema.as_value());
    }
    text.push_str("\n## Parts of outcomes\n");
    for (name, schema) in generator.definitions() {
        section(&mut text, &format!("### {name}"), schema);
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
