//! Virtual robots from files whose keys carry units, and those that are part of the program.

use super::robot::VirtualRobot;
use super::schema;
use hysteron_base::{BadInput, file};
use hysteron_rig::Result;
use std::path::Path;

/// Robots that are part of the program.
const PRESETS: [(&str, &str); 4] = [
    ("mild", include_str!("../../presets/mild.toml")),
    ("typical", include_str!("../../presets/typical.toml")),
    ("harsh", include_str!("../../presets/harsh.toml")),
    ("wide", include_str!("../../presets/wide.toml")),
];

impl VirtualRobot {
    /// Reads and validates a file.
    ///
    /// # Errors
    /// `BadInput` naming the key, what it may be and what it was; `File` if the file cannot be read.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        Self::from_toml(&file::read_text(path)?, &path.display().to_string())
    }

    /// The robot in the text of a file; `place` names the file in messages.
    ///
    /// # Errors
    /// As [`VirtualRobot::read`].
    pub fn from_toml(text: &str, place: &str) -> Result<Self> {
        let typed: schema::RobotFile = hysteron_base::schema::parse(text).map_err(|bad| bad.within(place))?;
        Ok(typed.checked().map_err(|bad| bad.within(place))?)
    }

    /// A preset: `mild`, `typical`, `harsh` or `wide`.
    ///
    /// # Errors
    /// `BadInput` for another name.
    pub fn preset(name: &str) -> Result<Self> {
        let Some((_, text)) = PRESETS.iter().find(|(known, _)| *known == name) else {
            let found = format!("\"{name}\"");
            return Err(
                BadInput::new("virtual robot", "mild, typical, harsh, wide or a file.toml", found).into()
            );
        };
        Self::from_toml(text, name)
    }

    /// The file of a preset; `None` for another name.
    pub fn preset_text(name: &str) -> Option<&'static str> {
        PRESETS.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
    }
}
