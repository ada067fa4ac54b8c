//! Which rig is meant: one on its ports, or the virtual one in this process.

use std::path::{Path, PathBuf};

use hysteron_base::{BadInput, file};
use hysteron_rig::calibration::RigCalibration;
use hysteron_rig::config::RigConfig;
use hysteron_virtual_rig::virtual_rig::{VirtualRobot, rig_file};

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
        /// Name of the robot.
        name: String,
        /// SHA-256 of that file and of the member of its population.
        hash: String,
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
                let expected =
                    "virtual:mild, virtual:typical, virtual:harsh, virtual:wide or virtual:ROBOT.toml";
                return Err(BadInput::new("--rig", expected, named.display().to_string()).into());
            }
        };
        let mut robot = VirtualRobot::from_toml(&text, base)?;
        if let Some(member) = member {
            robot = robot.draw(member);
        }
        let rig = RigConfig::from_toml(&rig_file(&robot), Path::new(""))?;
        let hash = file::sha256_hex(format!("{member:?} of\n{text}").as_bytes());
        Ok(Self::Virtual { rig, robot: Box::new(robot), text, name: name.to_owned(), hash })
    }

    /// Configuration of the rig.
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

    /// The calibration that was asked for; a virtual rig finds its own if there is none.
    pub fn calibration(&self, named: Option<&PathBuf>) -> anyhow::Result<Option<RigCalibration>> {
        let path = match self {
            Self::Live { rig, .. } => Some(calibration_path(rig, named)),
            Self::Virtual { .. } => named.cloned(),
        };
        Ok(path.map(|path| RigCalibration::read(&path, self.rig())).transpose()?)
    }

    /// Identity of the rig in its recordings: metadata keys and their values.
    pub fn identity(&self, seed: u64, calibration: Option<&RigCalibration>) -> Vec<(&'static str, String)> {
        let mut identity = vec![("rig.sha256", self.rig().hash.clone())];
        if let Self::Virtual { hash, .. } = self {
            identity.extend([("virtual.sha256", hash.clone()), ("virtual.seed", seed.to_string())]);
        }
        if let Some(calibration) = calibration {
            identity.push(("calibration.sha256", calibration.hash()));
        }
        identity
    }

    /// Files that describe it next to a data set, as they were when it was read: names and texts.
    pub fn description_files(&self) -> Vec<(&'static str, String)> {
        match self {
            Self::Live { text, .. } => vec![("rig.toml", text.clone())],
            Self::Virtual { text, robot, .. } => {
                vec![("rig.toml", rig_file(robot)), ("robot.toml", text.clone())]
            }
        }
    }
}

/// Refuses a folder with other files of these names: they belong to other recordings.
pub fn check_description(folder: &Path, files: &[(&str, String)]) -> anyhow::Result<()> {
    for (name, text) in files {
        let path = folder.join(name);
        if path.exists() && file::read_text(&path)? != *text {
            return Err(of_another(&path).into());
        }
    }
    Ok(())
}

/// Writes those of these files that are not there.
pub fn write_description(folder: &Path, files: &[(&str, String)]) -> anyhow::Result<()> {
    for (name, text) in files.iter().filter(|(name, _)| !folder.join(name).exists()) {
        file::write_bytes(&folder.join(name), text)?;
    }
    Ok(())
}

/// Writes a calibration next to a data set; one that is there must be the same.
pub fn keep_calibration(folder: &Path, calibration: &RigCalibration) -> anyhow::Result<()> {
    let path = folder.join("calibration.toml");
    if !path.exists() {
        return Ok(file::write_bytes(&path, calibration.to_toml())?);
    }
    let found = RigCalibration::from_toml(&file::read_text(&path)?);
    if found.is_ok_and(|found| found.hash() == calibration.hash()) {
        Ok(())
    } else {
        Err(of_another(&path).into())
    }
}

fn of_another(path: &Path) -> BadInput {
    BadInput::new(path.display().to_string(), "the file of this command's rig, plan and seed", "another")
        .hint("the recordings next to it are of another command; choose another --out")
}

/// Where the calibration of a rig on its ports is.
pub fn calibration_path(rig: &RigConfig, named: Option<&PathBuf>) -> PathBuf {
    named.cloned().unwrap_or_else(|| rig.calibration.file.clone())
}
