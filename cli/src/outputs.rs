//! What a command may write over: what it would itself have made from the same arguments, and nothing else.
//!
//! A verb says what it reads and what it will write before it works. Files are told apart by what they are on the disk,
//! not by their names, so links and other spellings are seen through. Whether a file is the verb's own stands in the
//! file: every result holds the command that made it. What a rig has measured is never replaced, and no input either,
//! whatever the options.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use hysteron_base::{BadInput, Lock, Recording, Scene, file};
use hysteron_control::TargetPath;
use hysteron_learn::Checkpoint;

use crate::terminal;

/// Bytes at the beginning of a file in which its maker is looked for.
const HEAD: usize = 1 << 16;
/// Largest file of JSON that is looked into for its maker [byte].
const MOST_JSON: u64 = 64 << 20;
/// So says a picture in XML that it is of this program.
pub const SIGNATURE: &str = "<!-- generator: hysteron -->";
/// All ways in which pictures and pages say it.
const SIGNATURES: [&str; 3] =
    [SIGNATURE, "<meta name=\"generator\" content=\"hysteron\"/>", "Software\0hysteron"];
/// So begins a scene that was written, with the command behind it.
pub const MADE_BY: &str = "# made by: ";
/// Files of every report.
const REPORT: [&str; 2] = ["report.html", "metrics.json"];
/// Options that say where something goes and not what it is; those with a value, and those without.
const WHERE: [&str; 5] = ["--out", "--figures", "--vtu", "--vtu-every", "--save-state"];
const HOW: [&str; 3] = ["--png", "--resume", "--overwrite"];

static MAY_OVERWRITE: AtomicBool = AtomicBool::new(false);

/// Results of this program that other arguments have made may be replaced too, in this process.
pub fn allow_overwriting() {
    MAY_OVERWRITE.store(true, Ordering::Relaxed);
}

/// What a command reads and what it will write.
#[derive(Debug, Default)]
pub struct Outputs {
    reads: Vec<PathBuf>,
    /// The option that names it, and the file.
    files: Vec<(&'static str, PathBuf)>,
    folders: Vec<(&'static str, PathBuf)>,
}

/// Keeps other processes from writing the same files, for as long as it lives.
#[must_use]
#[derive(Debug)]
pub struct Claim {
    _locks: Vec<Lock>,
}

/// Who made a file.
#[derive(Debug, PartialEq)]
enum Maker {
    /// This program, with this command.
    Command(String),
    /// This program.
    Program,
    Another,
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
        self.and([path, &scene.mesh_path])
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

    /// Locks what will be written, and refuses what must not be replaced.
    ///
    /// # Errors
    /// `BadInput` naming the option, the file and why; one also where another process is writing there.
    pub fn check(self) -> anyhow::Result<Claim> {
        for (option, folder) in &self.folders {
            check_folder(option, folder)?;
            self.check_pictures(option, folder)?;
        }
        for (option, path) in &self.files {
            check_folder(option, path.parent().unwrap_or(Path::new("")))?;
        }
        let claim = self.claim()?;
        for (k, (option, path)) in self.files.iter().enumerate() {
            let twice =
                self.files[..k].iter().find(|(_, earlier)| earlier == path || file::is_same(earlier, path));
            if let Some((other, _)) = twice {
                let expected = format!("another file than {other} names");
                return Err(BadInput::new(*option, expected, path.display().to_string()).into());
            }
            self.check_no_input(option, path)?;
            check_replaceable(option, path)?;
        }
        let written = self.files.iter().filter_map(|(_, path)| path.parent());
        written.chain(self.folders.iter().map(|(_, path)| path.as_path())).for_each(file::clear_temporary);
        Ok(claim)
    }

    /// Locks the folders, and the files that are in none of them.
    fn claim(&self) -> Result<Claim, hysteron_base::Error> {
        let folders = self.folders.iter().map(|(_, folder)| Lock::folder(folder));
        let is_in_folder = |path: &Path| self.folders.iter().any(|(_, folder)| path.starts_with(folder));
        let files =
            self.files.iter().filter(|(_, path)| !is_in_folder(path)).map(|(_, path)| Lock::file(path));
        let mut locks = folders.chain(files).collect::<Result<Vec<_>, _>>()?;
        // The first one in a new folder takes it away again if nothing was written, after all others there.
        locks.reverse();
        Ok(Claim { _locks: locks })
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
fn check_replaceable(option: &str, path: &Path) -> Result<(), BadInput> {
    let shown = path.display();
    let Ok(metadata) = std::fs::metadata(path) else { return Ok(()) };
    if !metadata.is_file() {
        let found = if metadata.is_dir() { "folder" } else { "device or pipe" };
        return Err(BadInput::new(option, "the name of a file", format!("the {found} {shown}")));
    }
    let refused = |found: String, hint: String| {
        Err(BadInput::new(option, "a new file, or one that this command has made", found).hint(hint))
    };
    match maker(path) {
        Maker::Another => refused(
            format!("{shown}, which hysteron has not made"),
            format!("move it away, or choose another {option}"),
        ),
        Maker::Program => Ok(()),
        Maker::Command(command) if is_measurement(&command) => refused(
            format!("{shown}, which was measured"),
            format!("a measurement is never overwritten: choose another {option}"),
        ),
        Maker::Command(command)
            if MAY_OVERWRITE.load(Ordering::Relaxed)
                || has_same_arguments(&command, &terminal::command_line()) =>
        {
            Ok(())
        }
        Maker::Command(command) => refused(
            format!("{shown}, made by `{command}`"),
            format!("choose another {option}, or add --overwrite"),
        ),
    }
}

/// Refuses a folder with a report that this program has not written, whatever its arguments were.
///
/// # Errors
/// `BadInput` naming the option and the file.
pub fn check_report(option: &str, folder: &Path) -> Result<(), BadInput> {
    check_folder(option, folder)?;
    let another = REPORT
        .map(|name| folder.join(name))
        .into_iter()
        .find(|path| path.exists() && maker(path) == Maker::Another);
    another.map_or(Ok(()), |path| {
        let found = format!("{}, which hysteron has not made", path.display());
        Err(BadInput::new(option, "a folder without another's report", found)
            .hint(format!("choose another {option}")))
    })
}

/// Replaces a picture or a page of this program; another's is refused.
pub fn replace(path: &Path, bytes: impl AsRef<[u8]>) -> anyhow::Result<()> {
    if path.exists() && maker(path) == Maker::Another {
        let place = path.display().to_string();
        return Err(BadInput::new(place, "a new file, or one by hysteron", "another's")
            .hint("move it away, or choose another folder")
            .into());
    }
    Ok(file::write_bytes(path, bytes)?)
}

/// Who made a file, as far as it says.
fn maker(path: &Path) -> Maker {
    let by =
        |command: Option<String>| command.filter(|it| !it.is_empty()).map_or(Maker::Another, Maker::Command);
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("parquet" | "csv") => return by(Recording::read_metadata(path).ok().map(|meta| meta.command)),
        Some("safetensors") => {
            let details = Checkpoint::read_details(path).unwrap_or_default();
            return by(details["training"]["command"].as_str().map(str::to_owned));
        }
        _ => {}
    }
    let Ok(head) = file::read_head(path, HEAD) else { return Maker::Another };
    if let Some(json) = json(path, &head) {
        let is_ours = json["format"].as_str().is_some_and(|format| format.starts_with("hysteron-"));
        let command = json["command"].as_str().map_or(Maker::Program, |it| Maker::Command(it.to_owned()));
        return if is_ours { command } else { Maker::Another };
    }
    let text = String::from_utf8_lossy(&head);
    if let Some(command) = text.strip_prefix(MADE_BY).and_then(|rest| rest.lines().next()) {
        return by(Some(command.to_owned()));
    }
    if SIGNATURES.iter().any(|signature| text.contains(signature)) { Maker::Program } else { Maker::Another }
}

/// The JSON that a file is, or begins with on a line of its own.
fn json(path: &Path, head: &[u8]) -> Option<serde_json::Value> {
    if head.first() != Some(&b'{') {
        return None;
    }
    let line = head.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let line = serde_json::from_slice(line).ok();
    line.or_else(|| serde_json::from_slice(&file::read_up_to(path, MOST_JSON).ok()?).ok())
}

/// Whether a command asks a rig.
fn is_measurement(command: &str) -> bool {
    matches!(words(command).get(1).map(String::as_str), Some("record" | "track" | "rig"))
        && words(&terminal::command_line()).get(1) != words(command).get(1)
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

/// The words of a command as [`terminal::shown`] writes it.
fn words(command: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let (mut is_quoted, mut characters) = (false, command.chars());
    while let Some(c) = characters.next() {
        match c {
            '\'' => is_quoted = !is_quoted,
            ' ' if !is_quoted => words.push(String::new()),
            '\\' if !is_quoted => {
                words.iter_mut().last().into_iter().for_each(|word| word.extend(characters.next()))
            }
            c => words.iter_mut().last().into_iter().for_each(|word| word.push(c)),
        }
    }
    words
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

    #[test]
    fn words_are_those_that_were_typed() {
        let typed = ["simulate", "my scene.toml", "it's", ""].map(str::to_owned);
        assert_eq!(words(&terminal::shown(typed.clone().into_iter()))[1..], typed);
    }

    #[test]
    fn the_maker_of_a_file_stands_in_it() {
        let folder = tempfile::tempdir().unwrap();
        let maker = |name: &str, content: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, content).unwrap();
            maker(&path)
        };
        let by = |command: &str| Maker::Command(command.to_owned());
        let table = "time_s,tip_x_mm\n0,1\n";
        assert_eq!(maker("a.csv", table), Maker::Another);
        assert_eq!(maker("a.csv", &format!("# command: hysteron reach\n{table}")), by("hysteron reach"));
        assert_eq!(maker("a.json", "{\"command\": \"hysteron x\"}"), Maker::Another);
        let json = "{\n\"format\": \"hysteron-metrics\",\n\"command\": \"hysteron x\"\n}\n";
        assert_eq!(maker("a.json", json), by("hysteron x"));
        let state = "{\"format\":\"hysteron-state\",\"command\":\"hysteron simulate\"}\n\0\0";
        assert_eq!(maker("a.state", state), by("hysteron simulate"));
        assert_eq!(maker("a.svg", "<svg></svg>"), Maker::Another);
        assert_eq!(maker("a.svg", &format!("<svg>{}</svg>", SIGNATURES[0])), Maker::Program);
        assert_eq!(
            maker("a.toml", "# made by: hysteron fit-material a\nname"),
            by("hysteron fit-material a")
        );
        assert_eq!(maker("a.safetensors", "not one"), Maker::Another);
    }
}
