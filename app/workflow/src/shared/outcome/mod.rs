//! The outcome of a verb: one struct with every number that is shown or stored. `metrics.json`, `--json`, the page and the
//! console are all made from it.

mod document;

use std::borrow::Cow;

pub use document::{MARK, VERBS, VerbOutcome, document, rewrite, verb};
use hysteron_base::json;
use hysteron_report::verdict::Verdict;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{DeserializeOwned, Error as _};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The result type of a verb.
pub trait Outcome: Serialize + DeserializeOwned + JsonSchema {
    /// The verdict on the result, of verbs that give one.
    fn verdict(&self) -> Option<&Verdict> {
        None
    }

    /// Tables for people, line by line, of verbs that show them below their verdict.
    fn lines(&self) -> Vec<String> {
        Vec::new()
    }
}

/// An outcome as a terminal prints it.
#[derive(Debug)]
pub struct Printed {
    /// The verdict, for people.
    pub verdict: Option<Verdict>,
    /// Lines below it.
    pub lines: Vec<String>,
    /// The whole outcome as JSON, for programs.
    pub json: String,
}

impl Printed {
    /// Of any verb's outcome.
    ///
    /// # Errors
    /// Those of writing JSON.
    pub fn new<T: Outcome>(outcome: &T) -> anyhow::Result<Self> {
        let (verdict, lines) = (outcome.verdict().cloned(), outcome.lines());
        Ok(Self { verdict, lines, json: json::to_text(outcome)? })
    }

    /// Of a verb without an outcome.
    pub fn nothing() -> Self {
        Self { verdict: None, lines: Vec::new(), json: "{}\n".to_owned() }
    }
}

/// Reads one of two objects: `with` where the key is there, `without` where it is not. (What serde holds back to choose a variant
/// by itself has lost the numbers that are not finite.)
///
/// # Errors
/// Those of reading the chosen object.
pub fn by_key<'de, D: Deserializer<'de>, A: DeserializeOwned, B: DeserializeOwned, T>(
    deserializer: D,
    key: &str,
    with: impl FnOnce(A) -> T,
    without: impl FnOnce(B) -> T,
) -> Result<T, D::Error> {
    let object = json::Value::deserialize(deserializer)?;
    match object.get(key) {
        Some(_) => json::from_value(&object).map(with),
        None => json::from_value(&object).map(without),
    }
    .map_err(D::Error::custom)
}

/// The value of `format` in every `metrics.json`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct MetricsFormat;

impl MetricsFormat {
    const TEXT: &str = "hysteron-metrics";
}

impl Serialize for MetricsFormat {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(Self::TEXT)
    }
}

impl<'de> Deserialize<'de> for MetricsFormat {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match String::deserialize(deserializer)?.as_str() {
            Self::TEXT => Ok(Self),
            other => {
                Err(D::Error::custom(format_args!("expected format \"{}\", got \"{other}\"", Self::TEXT)))
            }
        }
    }
}

impl JsonSchema for MetricsFormat {
    fn schema_name() -> Cow<'static, str> {
        "MetricsFormat".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "const": Self::TEXT })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use super::*;

    #[test]
    fn only_metrics_are_read_as_metrics() {
        let text = json::to_text(MetricsFormat).unwrap();
        assert_eq!(text.trim(), "\"hysteron-metrics\"");
        assert_eq!(json::from_text::<MetricsFormat>(text).unwrap(), MetricsFormat);
        let error = json::from_text::<MetricsFormat>("\"hysteron-scene\"").unwrap_err().to_string();
        assert!(error.starts_with("expected format \"hysteron-metrics\", got \"hysteron-scene\""), "{error}");
    }
}
