//! Logs of bam (github.com/Rhoban/bam): JSON, either a list of samples under `entries`, or lists of equal length.

use std::collections::BTreeMap;
use std::path::Path;

use crate::{BadInput, Column, Result, Table, file, json};
use serde_json::{Map, Value};

/// Metadata: gain of the position loops.
pub const POSITION_GAIN: &str = "position_gain";

/// Largest log [byte]; an hour at 200 Hz has less.
const MAX_BYTES: u64 = 256 << 20;
/// Names of the numbers next to the samples: in the log, in a recording.
const NOTES: [(&str, &str); 8] = [
    ("mass", "mass_kg"),
    ("m", "mass_kg"),
    ("arm_mass", "arm_mass_kg"),
    ("length", "length_m"),
    ("l", "length_m"),
    ("kp", POSITION_GAIN),
    ("vin", "supply_v"),
    ("motor", "motor"),
];

/// The samples, and the notes of the log as pairs of metadata.
pub(super) fn read(path: &Path) -> Result<(Table, Vec<(String, String)>)> {
    let bytes = file::read_up_to(path, MAX_BYTES)?;
    Ok(parse(&bytes).map_err(|bad| bad.within(path.display()))?)
}

fn parse(bytes: &[u8]) -> std::result::Result<(Table, Vec<(String, String)>), BadInput> {
    let log: Map<String, Value> = json::from_text(bytes).map_err(|error| {
        BadInput::new(format!("line {}", error.line()), "a log of bam (a JSON object)", error.to_string())
    })?;
    let columns = match log.get("entries") {
        Some(Value::Array(entries)) => of_entries(entries)?,
        Some(_) => return Err(BadInput::new("entries", "a list of samples", "something else")),
        None => of_lists(&log),
    };
    if columns.is_empty() {
        return Err(BadInput::new("", "a log of bam: samples under \"entries\"", "none"));
    }
    let note = |(key, value): (&String, &Value)| {
        let text = match value {
            Value::String(text) => text.clone(),
            Value::Number(_) | Value::Bool(_) => value.to_string(),
            _ => return None,
        };
        let known = NOTES.iter().find(|(name, _)| name == key).map(|(_, name)| (*name).to_owned());
        let spelled = key.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_');
        Some((known.or_else(|| spelled.then(|| format!("bam.{key}")))?, text))
    };
    Ok((Table::new(columns)?, log.iter().filter_map(note).collect()))
}

fn of_entries(entries: &[Value]) -> std::result::Result<Vec<Column>, BadInput> {
    let Some(Value::Object(first)) = entries.first() else {
        return Err(BadInput::new("entries", "at least one sample", "none"));
    };
    let mut columns: BTreeMap<&str, Vec<f64>> =
        first.keys().map(|key| (key.as_str(), Vec::with_capacity(entries.len()))).collect();
    for entry in entries {
        for (key, values) in &mut columns {
            values.push(entry.get(*key).map_or(f64::NAN, number));
        }
    }
    Ok(columns.into_iter().map(|(name, values)| Column { name: name.to_owned(), values }).collect())
}

fn of_lists(log: &Map<String, Value>) -> Vec<Column> {
    let list = |(name, value): (&String, &Value)| {
        let values = value.as_array()?.iter().map(number).collect();
        Some(Column { name: name.clone(), values })
    };
    log.iter().filter_map(list).collect()
}

/// The number of a value, 0 or 1 of a flag, NaN of anything else.
fn number(value: &Value) -> f64 {
    match value {
        Value::Bool(flag) => f64::from(u8::from(*flag)),
        _ => value.as_f64().unwrap_or(f64::NAN),
    }
}
