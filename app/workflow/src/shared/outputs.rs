//! Files that a command may overwrite: those that it would itself have made from the same arguments, and no
//! others.
//!
//! A verb declares its inputs and outputs before it works. Files are compared by identity on the disk,
//! not by their names, so links and other spellings are resolved. Whether a file is the verb's own is decided by the
//! file: every result holds the command that made it. What a rig has measured is never replaced, and no input either,
//! with any options.

use std::path::{Path, PathBuf};

use hysteron_base::{BadInput, Lock, Scene, file};
use hysteron_control::TargetPath;
use hysteron_learn::{Checkpoint, read_parameters_details};
pub use hysteron_report::maker::SIGNATURE;
use hysteron_report::maker::{self, Maker};
use serde::Deserialize;

use crate::Context;
use crate::shared::command_line::words;

/// Files of every report.
const REPORT: [&str; 2] = ["report.html", "metrics.json"];
/// Options for the place of outputs, which do not change them; those with a value, and those without.
const WHERE: [&str; 5] = ["--out", "--figures", "--vtu", "--vtu-every", "--save-state"];
const HOW: [&str; 3] = ["--png", "--resume", "--overwrite"];

/// Files that a command reads and those that it will write.
#[derive(Debug, Default)]
pub struct Outputs {
    reads: Vec<PathBuf>,
    /// The option that names it, and the file.
    files: Vec<(&'static str, PathBuf)>,
    /// The option, the file, and the endings that its name may have.
    endings: Vec<(&'static str, PathBuf, &'static [&'static str])>,
    folders: Vec<(&'static str, PathBuf)>,
    /// Files that sum up a folder of results.
    summaries: Vec<PathBuf>,
}

/// Keeps other processes from writing the same files, for as long as it lives.
#[must_use]
#[derive(Debug)]
pub struct OutputLock {
    _locks: Vec<Lock>,
}

impl Outputs {
    /// Of a command that reads these files.
    pub fn reading<P: Into<PathBuf>>(paths: impl IntoIterator<Item = P>) -> Self {
        Self { reads: paths.into_iter().map(Into::into).collect(), ..Self::default() }
    }

    /// It reads these too.
    pub fn and<P: Into<PathBuf>>(mut self, paths: impl IntoIterator<Item = P>) -> Self {
        self.reads.extend(paths.into_iter().map(Into::into));
        self
    }

    /// It reads a scene and what that names.
    pub fn scene(self, path: &Path, scene: &Scene) -> Self {
        self.and([path, &scene.mesh_path]).and(&scene.reduced_path)
    }

    /// It reads a target and what that names.
    pub fn target(self, named: &str) -> anyhow::Result<Self> {
        let files = TargetPath::files(named)?;
        Ok(self.and(files))
    }

    /// It writes a file, which an option names.
    pub fn file(mut self, option: &'static str, path: impl Into<PathBuf>) -> Self {
        self.files.push((option, path.into()));
        self
    }

    /// It writes a recording, which an option names.
    pub fn recording(self, option: &'static str, path: impl Into<PathBuf>) -> Self {
        self.ending(option, path.into(), &["parquet", "csv"])
    }

    /// It writes a model that learned, which an option names.
    pub fn learned(self, option: &'static str, path: impl Into<PathBuf>) -> Self {
        self.ending(option, path.into(), &["safetensors"])
    }

    /// It writes a file whose ending gives its kind.
    fn ending(mut self, option: &'static str, path: PathBuf, endings: &'static [&'static str]) -> Self {
        self.endings.push((option, path.clone(), endings));
        self.file(option, path)
    }

    /// It writes files to a folder, none of them alone.
    pub fn folder(mut self, option: &'static str, path: impl Into<PathBuf>) -> Self {
        self.folders.push((option, path.into()));
        self
    }

    /// It writes a report to a folder, if there is one.
    pub fn report(self, option: &'static str, folder: Option<&Path>) -> Self {
        let Some(folder) = folder else { return self };
        REPORT.iter().fold(self.folder(option, folder), |all, name| all.file(option, folder.join(name)))
    }

    /// It writes a report to a folder of results to which runs add: it sums up what is there, so that of an earlier run of
    /// the same verb is replaced, for any recordings. The results are refused or accepted one by one.
    pub fn report_of_results(mut self, option: &'static str, folder: &Path) -> Self {
        self.summaries.extend(REPORT.map(|name| folder.join(name)));
        self.report(option, Some(folder))
    }

    /// Locks what will be written, and refuses what must not be replaced.
    ///
    /// # Errors
    /// `BadInput` naming the option, the file and why; one also where another process is writing there.
    pub fn check(self, context: &Context) -> anyhow::Result<OutputLock> {
        for (option, path, endings) in &self.endings {
            let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
            if !endings.contains(&ending) {
                let expected = format!("a file .{}", endings.join(" or ."));
                return Err(BadInput::new(*option, expected, path.display().to_string()).into());
            }
        }
        for (option, folder) in &self.folders {
            check_folder(option, folder)?;
            self.check_pictures(option, folder)?;
        }
        for (option, path) in &self.files {
            file::check_name(path).map_err(|bad| bad.within(option))?;
            check_folder(option, path.parent().unwrap_or(Path::new("")))?;
        }
        let lock = self.lock()?;
        for (k, (option, path)) in self.files.iter().enumerate() {
            let twice =
                self.files[..k].iter().find(|(_, earlier)| earlier == path || file::is_same(earlier, path));
            if let Some((other, _)) = twice {
                let expected = format!("another file than {other} names");
                return Err(BadInput::new(*option, expected, path.display().to_string()).into());
            }
            self.check_no_input(option, path)?;
            if !(self.summaries.contains(path) && has_same_verb(&maker_of(path), context)) {
                check_replaceable(option, path, context)?;
            }
        }
        Ok(lock)
    }

    /// Locks the folders, and the files that are in none of them.
    fn lock(&self) -> Result<OutputLock, hysteron_base::Error> {
        let folders = self.folders.iter().map(|(_, folder)| Lock::folder(folder));
        let is_in_folder = |path: &Path| self.folders.iter().any(|(_, folder)| path.starts_with(folder));
        let files =
            self.files.iter().filter(|(_, path)| !is_in_folder(path)).map(|(_, path)| Lock::file(path));
        let mut locks = folders.chain(files).collect::<Result<Vec<_>, _>>()?;
        // The first one in a new folder takes it away again if nothing was written, after all others there.
        locks.reverse();
        Ok(OutputLock { _locks: locks })
    }

    fn check_no_input(&self, option: &str, path: &Path) -> Result<(), BadInput> {
        match self.reads.iter().find(|read| file::is_same(read, path)) {
            None => Ok(()),
            Some(read) => {
                let expected = format!("another file than the input {}", read.display());
                Err(BadInput::new(option, expected, path.display().to_string())
                    .hint(format!("choose another {option}")))
            }
        }
    }

    /// A picture that goes in must not lie where those go that come out.
    fn check_pictures(&self, option: &str, folder: &Path) -> Result<(), BadInput> {
        let is_picture = |path: &&PathBuf| {
            let ending = path.extension().and_then(|ending| ending.to_str());
            matches!(ending, Some("svg" | "png" | "html" | "json" | "vtu" | "vtp" | "pvd"))
                && file::is_same(file::folder_of(path), folder)
        };
        match self.reads.iter().find(is_picture) {
            None => Ok(()),
            Some(read) => {
                let found = folder.display().to_string();
                Err(BadInput::new(
                    option,
                    format!("another folder than that of the input {}", read.display()),
                    found,
                ))
            }
        }
    }
}

/// Refuses a folder that there cannot be.
fn check_folder(option: &str, folder: &Path) -> Result<(), BadInput> {
    match folder.ancestors().find(|path| path.exists()) {
        Some(there) if !there.is_dir() => {
            let found = format!("{}, which is a file", there.display());
            Err(BadInput::new(option, "a folder", found).hint(format!("choose another {option}")))
        }
        _ => Ok(()),
    }
}

/// Refuses to replace what this command, with these arguments, has not made.
fn check_replaceable(option: &str, path: &Path, context: &Context) -> Result<(), BadInput> {
    let shown = path.display();
    let Ok(metadata) = std::fs::metadata(path) else { return Ok(()) };
    if !metadata.is_file() {
        let found = if metadata.is_dir() { "folder" } else { "device or pipe" };
        return Err(BadInput::new(option, "the name of a file", format!("the {found} {shown}")));
    }
    let refused = |found: String, hint: String| {
        Err(BadInput::new(option, "a new file, or one that this command has made", found).hint(hint))
    };
    match maker_of(path) {
        Maker::Another => refused(
            format!("{shown}, which hysteron has not made"),
            format!("move it away, or choose another {option}"),
        ),
        Maker::Program => Ok(()),
        Maker::Command(command) if is_measurement(&command, context) => refused(
            format!("{shown}, which was measured"),
            format!("a measurement is never overwritten: choose another {option}"),
        ),
        Maker::Command(command) if context.overwrite || has_same_arguments(&command, &context.command) => {
            Ok(())
        }
        Maker::Command(command) => refused(
            format!("{shown}, made by `{command}`"),
            format!("choose another {option}, or add --overwrite"),
        ),
    }
}

/// Refuses a folder with a report that this program has not written, with any arguments.
///
/// # Errors
/// `BadInput` naming the option and the file.
pub fn check_report(option: &str, folder: &Path) -> Result<(), BadInput> {
    check_folder(option, folder)?;
    let another = REPORT
        .map(|name| folder.join(name))
        .into_iter()
        .find(|path| path.exists() && maker_of(path) == Maker::Another);
    another.map_or(Ok(()), |path| {
        let found = format!("{}, which hysteron has not made", path.display());
        Err(BadInput::new(option, "a folder without another's report", found)
            .hint(format!("choose another {option}")))
    })
}

/// Who made a file, a checkpoint too.
fn maker_of(path: &Path) -> Maker {
    if path.extension().is_none_or(|ending| ending != "safetensors") {
        return maker::maker(path);
    }
    let made = match Checkpoint::<NetworkDetails>::read_details(path) {
        Ok(details) => details.training,
        Err(_) => read_parameters_details::<ParameterDetails>(path).unwrap_or_default().details,
    };
    match made.command.filter(|command| !command.is_empty()) {
        Some(command) => Maker::Command(command),
        None => Maker::Another,
    }
}

/// The provenance in a network's details.
#[derive(Deserialize)]
struct NetworkDetails {
    #[serde(default)]
    training: MadeBy,
}

/// The same of other parameters.
#[derive(Default, Deserialize)]
struct ParameterDetails {
    #[serde(default)]
    details: MadeBy,
}

#[derive(Default, Deserialize)]
struct MadeBy {
    command: Option<String>,
}

/// Whether a file is of this verb, or a page that does not name its verb.
fn has_same_verb(maker: &Maker, context: &Context) -> bool {
    match maker {
        Maker::Command(command) => words(command).get(1) == words(&context.command).get(1),
        Maker::Program => true,
        Maker::Another => false,
    }
}

/// Whether a command asks a rig.
fn is_measurement(command: &str, context: &Context) -> bool {
    matches!(words(command).get(1).map(String::as_str), Some("record" | "track" | "rig"))
        && words(&context.command).get(1) != words(command).get(1)
}

/// Whether two commands make the same, wherever they write it.
fn has_same_arguments(a: &str, b: &str) -> bool {
    let kept = |command: &str| {
        let mut words = words(command).into_iter();
        let mut kept = Vec::new();
        while let Some(word) = words.next() {
            if WHERE.contains(&word.as_str()) {
                words.next();
            } else if !HOW.contains(&word.as_str())
                && !WHERE
                    .iter()
                    .any(|option| word.strip_prefix(option).is_some_and(|rest| rest.starts_with('=')))
            {
                kept.push(word);
            }
        }
        kept
    };
    kept(a) == kept(b)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands
    use super::*;

    #[test]
    fn the_same_arguments_wherever_the_results_go() {
        let command = "hysteron simulate scene.toml --strokes a.csv --out b.csv";
        for same in [
            "hysteron simulate scene.toml --strokes a.csv --out ./b.csv --figures 'my figures' --png",
            "hysteron simulate scene.toml --out=c.csv --strokes a.csv --resume --save-state x",
        ] {
            assert!(has_same_arguments(command, same), "{same}");
        }
        for other in [
            "hysteron simulate scene.toml --strokes b.csv --out b.csv",
            "hysteron reach scene.toml --strokes a.csv --out b.csv",
            "hysteron simulate scene.toml --strokes a.csv --residual n --out b.csv",
        ] {
            assert!(!has_same_arguments(command, other), "{other}");
        }
    }
}
