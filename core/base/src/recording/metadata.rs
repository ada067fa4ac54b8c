//! Where a recording comes from: what every file states before its numbers.
//!
//! Both kinds of file store pairs of text; only this module knows their keys. `format` and `version` are not
//! kept, since a recording in memory always has the current ones.

use super::{Check, FORMAT, VERSION};
use crate::BadInput;
use std::collections::{BTreeMap, BTreeSet};

/// Provenance of a recording. Empty where a file has none.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Metadata {
    /// SHA-256 of the scene file, see [`crate::Scene::hash`].
    pub scene_hash: String,
    /// Seed of the random streams that shaped it.
    pub seed: Option<u64>,
    /// Commit of the program that made it.
    pub commit: String,
    /// Origin of the recording: a rig, a simulation, a plan.
    pub source: String,
    /// Command line that made it.
    pub command: String,
    /// Anything else, by key; keys are lower-case letters, digits, `_` and `.`.
    pub extra: BTreeMap<String, String>,
}

const KEYS: [&str; 7] = ["format", "version", "scene_hash", "seed", "commit", "source", "command"];

/// True for what can be a key of [`Metadata`].
pub(super) fn is_key(key: &str) -> bool {
    !key.is_empty()
        && key.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_' || b == b'.')
}

/// A value for a message: what cannot be seen is named.
fn shown(value: String) -> String {
    if value.trim().is_empty() { "nothing".to_owned() } else { value }
}

impl Metadata {
    pub(super) fn check(&self) -> Check<()> {
        match self.extra.keys().find(|key| !is_key(key) || KEYS.contains(&key.as_str())) {
            Some(key) => Err(BadInput::new(
                "metadata",
                "other keys of lower-case letters, digits, _ and .",
                format!("{key:?}"),
            )),
            None => Ok(()),
        }
    }

    /// All pairs of a file, format and version first.
    pub(super) fn to_pairs(&self) -> Vec<(String, String)> {
        let values = [
            FORMAT.to_owned(),
            VERSION.to_string(),
            self.scene_hash.clone(),
            self.seed.map_or_else(String::new, |seed| seed.to_string()),
            self.commit.clone(),
            self.source.clone(),
            self.command.clone(),
        ];
        let own = KEYS.iter().map(|key| (*key).to_owned()).zip(values);
        own.chain(self.extra.iter().map(|(key, value)| (key.clone(), value.clone()))).collect()
    }

    /// The inverse of [`Metadata::to_pairs`]; pairs may be missing, their keys are [`is_key`].
    pub(super) fn from_pairs(pairs: impl IntoIterator<Item = (String, String)>) -> Check<Self> {
        let mut meta = Self::default();
        let mut seen = BTreeSet::new();
        for (key, value) in pairs {
            if !seen.insert(key.clone()) {
                return Err(BadInput::new(format!("metadata {key}"), "each key once", "a second one"));
            }
            match key.as_str() {
                "format" if value == FORMAT => {}
                "format" => return Err(BadInput::new("metadata format", FORMAT, shown(value))),
                "version" if value == VERSION.to_string() => {}
                "version" => {
                    return Err(BadInput::new("metadata version", VERSION.to_string(), shown(value))
                        .hint("this program reads only that version of a recording"));
                }
                "scene_hash" => meta.scene_hash = value,
                "seed" if value.is_empty() => {}
                "seed" => {
                    let seed = value
                        .parse()
                        .map_err(|_| BadInput::new("metadata seed", "a whole number >= 0", shown(value)));
                    meta.seed = Some(seed?);
                }
                "commit" => meta.commit = value,
                "source" => meta.source = value,
                "command" => meta.command = value,
                _ => {
                    meta.extra.insert(key, value);
                }
            }
        }
        Ok(meta)
    }
}
