//! Outcomes as data classes, made from their schemas.
//!
//! A schema is JSON, and schemars has no types for its contents: the functions below take its parts as values.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use hysteron_base::json::Value;
use hysteron_studies::outcomes;
use schemars::generate::SchemaSettings;

use crate::text::{HEAD, class_name, identifier, quoted, wrapped};

/// The classes of all outcomes and their parts.
pub struct OutcomeClasses {
    /// Schemas of classes, by name.
    schemas: BTreeMap<String, Value>,
    /// Verbs, as they are typed, and their classes.
    verbs: BTreeMap<String, String>,
    /// Further names of a class that several verbs have.
    aliases: BTreeMap<String, String>,
}

impl OutcomeClasses {
    /// From the types of the program.
    pub fn of_all_verbs() -> Self {
        let mut generator = SchemaSettings::draft2020_12().into_generator();
        let mut classes = Self { schemas: BTreeMap::new(), verbs: BTreeMap::new(), aliases: BTreeMap::new() };
        for verb in outcomes::all() {
            let name = |verb: &str| class_name(verb) + "Outcome";
            let own = name(verb.names()[0]);
            classes.schemas.insert(own.clone(), verb.schema(&mut generator).to_value());
            for one in verb.names() {
                classes.verbs.insert((*one).to_owned(), name(one));
                if name(one) != own {
                    classes.aliases.insert(name(one), own.clone());
                }
            }
        }
        for (name, schema) in generator.definitions() {
            let name = class_name(name);
            assert!(!classes.schemas.contains_key(&name), "two classes {name}");
            classes.schemas.insert(name, schema.clone());
        }
        classes
    }

    /// The class of a verb's outcome.
    pub fn of_verb(&self, verb: &str) -> Option<&str> {
        self.verbs.get(verb).map(String::as_str)
    }

    /// The module `outcomes`.
    pub fn source(&self) -> String {
        let mut out = format!(
            "{HEAD}\"\"\"Outcomes of verbs: the keys of `metrics.json` and of `--json`; all numbers in SI.\"\"\"\n\n\
             # ruff: noqa\nfrom __future__ import annotations\n\nfrom dataclasses import dataclass, field\n\
             from typing import Any, Literal, Union\n\nfrom ._outcome import Outcome as _Outcome\n\n__all__ = [\n"
        );
        let names: BTreeSet<&String> = self.schemas.keys().chain(self.aliases.keys()).collect();
        for name in names {
            let _ = writeln!(out, "    {},", quoted(name));
        }
        out.push_str("]\n");
        let (classes, others): (Vec<_>, Vec<_>) =
            self.schemas.iter().partition(|(_, schema)| schema["properties"].is_object());
        for (name, schema) in classes {
            out.push_str(&class(name, schema));
        }
        out.push('\n');
        // A name stands below those that it is made of.
        let mut left: BTreeMap<&String, String> =
            others.into_iter().map(|(name, schema)| (name, kind(schema))).collect();
        while !left.is_empty() {
            let waits = |text: &str| left.keys().any(|other| mentions(text, other));
            let ready: Vec<&String> =
                left.iter().filter(|(_, text)| !waits(text)).map(|(name, _)| *name).collect();
            assert!(!ready.is_empty(), "a circle of names: {:?}", left.keys());
            for name in ready {
                let text = left.remove(name).unwrap_or_default();
                let description = description(&self.schemas[name]).unwrap_or_default();
                let _ = write!(out, "\n{name} = {text}\n\"\"\"{}\"\"\"\n", one_line(&description));
            }
        }
        for (name, own) in &self.aliases {
            let _ = write!(out, "\n{name} = {own}\n");
        }
        out
    }
}

/// Whether a type names another one.
fn mentions(text: &str, name: &str) -> bool {
    text.split(|c: char| !c.is_alphanumeric() && c != '_').any(|word| word == name)
}

/// An object as a data class.
fn class(name: &str, schema: &Value) -> String {
    let about = description(schema).unwrap_or_else(|| format!("Part of an outcome: {name}."));
    let mut out = format!(
        "\n\n@dataclass(frozen=True, kw_only=True)\nclass {name}(_Outcome):\n    \"\"\"{}\"\"\"\n",
        one_line(&about)
    );
    let required = schema["required"].as_array().cloned().unwrap_or_default();
    for (key, schema) in schema["properties"].as_object().into_iter().flatten() {
        let mut kind = kind(schema);
        let is_required = required.iter().any(|one| one == key);
        if !is_required && !kind.split(" | ").any(|one| one == "None") {
            kind.push_str(" | None");
        }
        let name = identifier(key);
        let default = match (name == *key, is_required) {
            (true, true) => String::new(),
            (true, false) => " = None".to_owned(),
            (false, true) => format!(" = field(metadata={{\"key\": {}}})", quoted(key)),
            (false, false) => format!(" = field(default=None, metadata={{\"key\": {}}})", quoted(key)),
        };
        let _ = write!(out, "\n    {name}: {kind}{default}\n");
        if let Some(about) = description(schema) {
            let _ = writeln!(out, "    \"\"\"{}\"\"\"", one_line(&about));
        }
    }
    out
}

fn description(schema: &Value) -> Option<String> {
    schema["description"].as_str().map(str::to_owned)
}

/// A text for a pair of triple quotes, wrapped as the body of a class is.
fn one_line(text: &str) -> String {
    let text = wrapped(text, 4, 0);
    let text = text.trim();
    // A quote at the end would join those behind it.
    if text.ends_with('"') { format!("{text} ") } else { text.to_owned() }
}

/// A schema as a type of Python.
fn kind(schema: &Value) -> String {
    if let Some(name) = schema["$ref"].as_str().and_then(|path| path.rsplit('/').next()) {
        return class_name(name);
    }
    if let Some(constant) = schema["const"].as_str() {
        return format!("Literal[{}]", quoted(constant));
    }
    if let Some(values) = schema["enum"].as_array() {
        let texts: Vec<String> = values.iter().filter_map(Value::as_str).map(quoted).collect();
        return format!("Literal[{}]", texts.join(", "));
    }
    for several in ["oneOf", "anyOf", "allOf"] {
        if let Some(schemas) = schema[several].as_array() {
            return union(schemas.iter().map(kind));
        }
    }
    match &schema["type"] {
        Value::Array(kinds) => {
            union(kinds.iter().filter_map(Value::as_str).map(|kind| one_kind(kind, schema)))
        }
        Value::String(kind) => one_kind(kind, schema),
        _ => "Any".to_owned(),
    }
}

/// One of several types, each once.
fn union(kinds: impl Iterator<Item = String>) -> String {
    let mut all: Vec<String> = Vec::new();
    for kind in kinds {
        if !all.contains(&kind) {
            all.push(kind);
        }
    }
    all.join(" | ")
}

fn one_kind(kind: &str, schema: &Value) -> String {
    match kind {
        "number" => "float".to_owned(),
        "integer" => "int".to_owned(),
        "string" => "str".to_owned(),
        "boolean" => "bool".to_owned(),
        "null" => "None".to_owned(),
        "array" => match schema["prefixItems"].as_array() {
            Some(items) => format!("list[{}]", union(items.iter().map(self::kind))),
            None => format!("list[{}]", self::kind(&schema["items"])),
        },
        "object" => match schema["properties"].as_object() {
            // A variant with content, as serde writes it.
            Some(properties) if properties.len() == 1 => {
                let variants = properties.iter().map(|(key, content)| (quoted(key), self::kind(content)));
                union(variants.map(|(key, content)| format!("dict[Literal[{key}], {content}]")))
            }
            Some(_) => "dict[str, Any]".to_owned(),
            None => format!("dict[str, {}]", self::kind(&schema["additionalProperties"])),
        },
        _ => "Any".to_owned(),
    }
}
