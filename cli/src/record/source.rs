//! Which rig is meant: one on its ports, or the virtual one in this process.

use std::path::{Path, PathBuf};

use hysteron_base::{BadInput, file};
use hysteron_rig::config::RigConfig;
use hysteron_rig::virtual_rig::{VirtualRobot, rig_file};

/// How a virtual rig is named on the command line.
const VIRTUAL: &str = "virtual:";

/// A rig as named on the command line.
#[derive(Debug)]
pub enum Source {
    /// On its ports.
    Live {
        /// Its rig file.
        rig: RigConfig,
        /// The text of that file.
        text: String,
    },
    /// In this process.
    Virtual {
        /// The rig file that goes with it.
        rig: RigConfig,
        /// Its physics.
        robot: Box<VirtualRobot>,
        /// The file of the robot, or of the one whose population it is from.
        text: String,
        /// What it is called.
        name: String,
    },
}

impl Source {
    /// From `RIG.toml`, `virtual:PRESET`, `virtual:ROBOT.toml`, either of these with `/MEMBER` of its population.
    pub fn read(named: &Path) -> anyhow::Result<Self> {
        let Some(name) = named.to_str().and_then(|text| text.strip_prefix(VIRTUAL)) else {
            let text = file::read_text(named)?;
            let folder = named.parent().unwrap_or(Path::new(""));
            let rig = RigConfig::from_toml(&text, folder).map_err(|bad| bad.within(named.display()))?;
            return Ok(Self::Live { rig, text });
        };
        let (base, member) = match name.rsplit_once('/') {
            Some((base, member)) if member.bytes().all(|b| b.is_ascii_digit()) && !member.is_empty() => {
                let member: u64 = member.parse().map_err(|_| {
                    BadInput::new("--rig", "a member of the population as a whole number", member)
                })?;
                (base, Some(member))
            }
            _ => (name, None),
        };
        let text = match VirtualRobot::preset_text(base) {
            Some(text) => text.to_owned(),
            None if base.ends_with(".toml") => file::read_text(Path::new(base))?,
            None => {
                let expected = "virtual:mild, virtual:typical, virtual:harsh or virtual:ROBOT.toml";
                return Err(BadInput::new("--rig", expected, named.display().to_string()).into());
            }
        };
        let mut robot = VirtualRobot::from_toml(&text, base)?;
        if let Some(member) = member {
            robot = robot.draw(member);
        }
        let rig = RigConfig::from_toml(&rig_file(&robot), Path::new(""))?;
        Ok(Self::Virtual { rig, robot: Box::new(robot), text, name: name.to_owned() })
    }

    /// What is written on the rig's file.
    pub fn rig(&self) -> &RigConfig {
        match self {
            Self::Live { rig, .. } | Self::Virtual { rig, .. } => rig,
        }
    }

    /// For the metadata of what it measures.
    pub fn description(&self) -> String {
        match self {
            Self::Live { rig, .. } => format!("rig {}", rig.name),
            Self::Virtual { name, .. } => format!("virtual rig {name}"),
        }
    }

    /// Writes the files that describe it beside a data set, as they were when it was read.
    pub fn write_description(&self, folder: &Path) -> anyhow::Result<()> {
        match self {
            Self::Live { text, .. } => file::write_bytes(&folder.join("rig.toml"), text)?,
            Self::Virtual { text, robot, .. } => {
                file::write_bytes(&folder.join("rig.toml"), rig_file(robot))?;
                file::write_bytes(&folder.join("robot.toml"), text)?;
            }
        }
        Ok(())
    }
}

/// Where the calibration of a rig on its ports is.
pub fn calibration_path(rig: &RigConfig, named: Option<&PathBuf>) -> PathBuf {
    named.cloned().unwrap_or_else(|| rig.calibration.file.clone())
}
