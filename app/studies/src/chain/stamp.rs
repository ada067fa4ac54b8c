//! Stamps: what a stage was made from and what it wrote, so that it is not done twice.
//!
//! A stamp without outputs marks a stage that was started. Nothing in it but `seconds` differs from run to run, and no
//! result holds that.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use hysteron_base::{BadInput, file, json};
use serde::{Deserialize, Serialize};

use super::stage::{Outdated, Restart, Stage};
use hysteron_workflow::COMMIT;

const FORMAT: &str = "hysteron-stamp";
const VERSION: u32 = 1;
/// So begin the names of files that are being written; one that stays is of a program that was killed.
const UNFINISHED: &str = ".hysteron-";
/// Ending of the names of locks. The study holds its own, so no stage is running.
const LOCK: &str = ".lock";

/// See the module.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stamp {
    format: String,
    version: u32,
    /// Version and commit of the program.
    program: String,
    /// Its commands, as [`super::stage::Argument::key`].
    commands: Vec<Vec<String>>,
    /// Name and SHA-256 of all files that it reads, in the order of the options.
    inputs: Vec<(String, String)>,
    /// Path in the folder of the stage, and SHA-256, of all files that it wrote; none while it is not finished.
    outputs: Option<BTreeMap<String, String>>,
    /// Time that it took [s].
    pub seconds: f64,
}

/// Status of a stage.
#[derive(Debug, PartialEq)]
pub enum StageStatus {
    /// Finished, from what is there now.
    Done,
    /// Never begun.
    New,
    /// Begun from what is there now, and not finished.
    Begun,
    /// Finished from what is there now, but these files of it were changed or are gone.
    Damaged(Vec<String>),
    /// Made from something else; what.
    Outdated(String),
}

impl Stamp {
    /// The stamp of a stage that begins now.
    pub fn begun(stage: &Stage) -> anyhow::Result<Self> {
        let mut inputs = Vec::new();
        for path in stage.steps.iter().flat_map(|step| &step.arguments).flat_map(|argument| &argument.reads) {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if path.is_dir() {
                inputs.extend(hashes(path)?.into_iter().map(|(file, hash)| (format!("{name}/{file}"), hash)));
            } else {
                inputs.push((name, file::sha256_of(path)?));
            }
        }
        let keys = stage.steps.iter().map(|step| step.arguments.iter().map(|it| it.key.clone()).collect());
        Ok(Self {
            format: FORMAT.to_owned(),
            version: VERSION,
            program: format!("{} {}", env!("CARGO_PKG_VERSION"), COMMIT),
            commands: keys.collect(),
            inputs,
            outputs: None,
            seconds: 0.0,
        })
    }

    /// The stamp of a stage in the folder of a study, if it was ever begun. One that cannot be read counts as none, and
    /// so does one that names files which are not in the folder of the stage.
    pub fn read(out: &Path, stage: &Stage) -> Option<Self> {
        let stamp: Self = json::from_text(&file::read_bytes(&place(out, stage)).ok()?).ok()?;
        let is_own = |name: &String| {
            Path::new(name).components().all(|part| matches!(part, Component::Normal(_))) && !name.is_empty()
        };
        let has_own = stamp.outputs.iter().flat_map(BTreeMap::keys).all(is_own);
        (stamp.format == FORMAT && stamp.version == VERSION && has_own).then_some(stamp)
    }

    /// Writes it.
    pub fn write(&self, out: &Path, stage: &Stage) -> anyhow::Result<()> {
        Ok(file::write_bytes(&place(out, stage), json::to_text(self)?)?)
    }

    /// The same with what the stage wrote.
    pub fn finished(mut self, out: &Path, stage: &Stage) -> anyhow::Result<Self> {
        self.outputs = Some(hashes(&out.join(&stage.folder))?);
        Ok(self)
    }

    /// Whether the stage came to its end, from any state.
    pub fn is_finished(&self) -> bool {
        self.outputs.is_some()
    }

    /// Status of a stage whose stamp would be `self` now and was `earlier`.
    pub fn status(&self, earlier: Option<&Self>, out: &Path, stage: &Stage) -> anyhow::Result<StageStatus> {
        let Some(earlier) = earlier else { return Ok(StageStatus::New) };
        if let Some(what) = self.difference(earlier, stage.outdated) {
            return Ok(StageStatus::Outdated(what));
        }
        let Some(outputs) = &earlier.outputs else { return Ok(StageStatus::Begun) };
        let found = hashes(&out.join(&stage.folder))?;
        let is_changed = |(name, hash): &(&String, &String)| found.get(*name) != Some(*hash);
        let changed: Vec<String> = outputs.iter().filter(is_changed).map(|(name, _)| name.clone()).collect();
        Ok(if changed.is_empty() { StageStatus::Done } else { StageStatus::Damaged(changed) })
    }

    /// Change in the inputs of a stage since the earlier stamp. A newer program does not spoil what was
    /// measured.
    fn difference(&self, earlier: &Self, outdated: Outdated) -> Option<String> {
        if self.commands != earlier.commands {
            return Some("its options".to_owned());
        }
        if self.inputs != earlier.inputs {
            let new = self.inputs.iter().find(|input| !earlier.inputs.contains(input));
            return Some(new.map_or("fewer files".to_owned(), |(name, _)| name.clone()));
        }
        (self.program != earlier.program && outdated == Outdated::Remove).then(|| "the program".to_owned())
    }
}

/// Removes the outdated and unfinished outputs of a stage before it runs; outputs from which it can resume stay.
///
/// # Errors
/// `BadInput` where files are in the way that the study did not make.
pub fn clear_outputs(
    out: &Path,
    stage: &Stage,
    status: &StageStatus,
    earlier: Option<&Stamp>,
) -> anyhow::Result<()> {
    let folder = out.join(&stage.folder);
    remove_unfinished(&folder)?;
    let can_resume = stage.restart == Restart::GoesOn;
    match status {
        StageStatus::Done => return Ok(()),
        StageStatus::Begun if can_resume => return Ok(()),
        StageStatus::Damaged(names) if can_resume => {
            for name in names.iter().filter(|name| folder.join(name).exists()) {
                match stage.outdated {
                    Outdated::Remove => remove(&folder, name)?,
                    Outdated::SetAside => set_aside(&folder.join(name))?,
                }
            }
            return Ok(());
        }
        _ => {}
    }
    if let Some(earlier) = earlier.filter(|_| folder.exists()) {
        match (stage.outdated, &earlier.outputs) {
            (Outdated::SetAside, _) => set_aside(&folder)?,
            (Outdated::Remove, Some(outputs)) => {
                for name in outputs.keys().filter(|name| folder.join(name).exists()) {
                    remove(&folder, name)?;
                }
            }
            // Nothing was there when it began.
            (Outdated::Remove, None) => std::fs::remove_dir_all(&folder)?,
        }
    }
    match files_in(&folder)?.first() {
        None => Ok(()),
        Some(file) => {
            let place = folder.display().to_string();
            let found = format!("{}, which this study did not write", file.display());
            Err(BadInput::new(place, "no files yet", found)
                .hint("move it away, or choose another --out")
                .into())
        }
    }
}

/// Removes a file of a stage. A link in the folder may lead out of it; what lies behind that is not the stage's.
fn remove(folder: &Path, name: &str) -> anyhow::Result<()> {
    let path = folder.join(name);
    let at = path.parent().unwrap_or(folder).canonicalize()?;
    if !at.starts_with(folder.canonicalize()?) {
        let found = format!("a link to {}", at.display());
        return Err(BadInput::new(path.display().to_string(), "a file of the study", found)
            .hint("move the link away")
            .into());
    }
    Ok(std::fs::remove_file(path)?)
}

/// Renames a measurement, with a warning.
fn set_aside(path: &Path) -> anyhow::Result<()> {
    let named = |number: usize| {
        let mut name = path.as_os_str().to_owned();
        name.push(format!(".earlier-{number}"));
        PathBuf::from(name)
    };
    let free = (1..).map(named).find(|path| !path.exists()).unwrap_or_else(|| named(0));
    std::fs::rename(path, &free)?;
    tracing::warn!("earlier measurements are now in {}", free.display());
    Ok(())
}

/// Removes what a killed program was writing, and its lock.
fn remove_unfinished(folder: &Path) -> anyhow::Result<()> {
    for path in files_in(folder)? {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if name.starts_with(UNFINISHED) || (name.starts_with('.') && name.ends_with(LOCK)) {
            std::fs::remove_file(path)?;
        }
    }
    Ok(())
}

fn place(out: &Path, stage: &Stage) -> PathBuf {
    out.join("stages").join(format!("{}.json", stage.name.replace(' ', ".")))
}

/// SHA-256 of all files in a folder and those in it, by their path in it.
fn hashes(folder: &Path) -> anyhow::Result<BTreeMap<String, String>> {
    let entry = |path: PathBuf| -> anyhow::Result<(String, String)> {
        let name = path.strip_prefix(folder).unwrap_or(&path).components();
        let name: Vec<_> = name.map(|part| part.as_os_str().to_string_lossy().into_owned()).collect();
        Ok((name.join("/"), file::sha256_of(&path)?))
    };
    files_in(folder)?.into_iter().map(entry).collect()
}

/// All files in a folder and those in it, sorted; none where there is no such folder.
fn files_in(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let mut folders = if folder.exists() { vec![folder.to_owned()] } else { Vec::new() };
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder)? {
            let entry = entry?;
            // Links are not followed: what they lead to is not in the folder.
            if entry.file_type()?.is_dir() { folders.push(entry.path()) } else { files.push(entry.path()) }
        }
    }
    files.sort();
    Ok(files)
}
