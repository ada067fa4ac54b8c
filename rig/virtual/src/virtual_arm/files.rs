//! Virtual arms from files whose keys carry units, and those that are part of the program.

use std::path::Path;

use hysteron_base::{BadInput, file};

use super::robot::VirtualArm;
use super::schema;
use hysteron_rig::Result;

/// Arms that are part of the program.
const PRESETS: [(&str, &str); 1] =
    [("open-manipulator-x", include_str!("../../presets/open-manipulator-x.toml"))];

impl VirtualArm {
    /// Reads and validates a file.
    ///
    /// # Errors
    /// `BadInput` naming the key, what it may be and what it was; `File` if the file cannot be read.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        Self::from_toml(&file::read_text(path)?, &path.display().to_string())
    }

    /// The arm in the text of a file; `place` names the file in messages.
    ///
    /// # Errors
    /// As [`VirtualArm::read`].
    pub fn from_toml(text: &str, place: &str) -> Result<Self> {
        let typed: schema::ArmFile = hysteron_base::schema::parse(text).map_err(|bad| bad.within(place))?;
        let hash = file::sha256_hex(text.as_bytes());
        Ok(typed.checked(hash).map_err(|bad| bad.within(place))?)
    }

    /// A preset: `open-manipulator-x`.
    ///
    /// # Errors
    /// `BadInput` for another name.
    pub fn preset(name: &str) -> Result<Self> {
        let Some(text) = Self::preset_text(name) else {
            let found = format!("\"{name}\"");
            return Err(BadInput::new("virtual arm", "open-manipulator-x or a file.toml", found).into());
        };
        Self::from_toml(text, name)
    }

    /// The file of a preset; `None` for another name.
    pub fn preset_text(name: &str) -> Option<&'static str> {
        PRESETS.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
    }
}
