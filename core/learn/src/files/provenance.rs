//! Who made a checkpoint, and the options of its training as its file holds them.

use hysteron_base::json;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer, Serialize};

/// The command and the program that made a checkpoint.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Provenance {
    /// The command.
    pub command: String,
    /// Commit of the program.
    pub commit: String,
    /// Version of the program.
    pub version: String,
}

/// Reads the options of a training where this program has them all, and none where a program of another version wrote others: a
/// network can be used without them.
///
/// # Errors
/// Those of the deserializer.
pub fn options_of_this_version<'de, D: Deserializer<'de>, T: DeserializeOwned>(
    deserializer: D,
) -> Result<Option<T>, D::Error> {
    Ok(json::from_value(&json::Value::deserialize(deserializer)?).ok())
}
