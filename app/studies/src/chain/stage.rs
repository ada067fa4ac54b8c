//! One stage of a study: the commands that a person could type, and the files that they read and write.

use std::path::{Path, PathBuf};

/// One argument of a command.
#[derive(Debug, Clone)]
pub struct Argument {
    /// As typed, with paths from the current folder.
    pub typed: String,
    /// Key in a stamp: it does not depend on the working directory.
    pub key: String,
    /// Files and folders whose content counts.
    pub reads: Vec<PathBuf>,
}

impl Argument {
    /// A word, without files.
    pub fn word(word: impl Into<String>) -> Self {
        let typed: String = word.into();
        Self { key: typed.clone(), typed, reads: Vec::new() }
    }

    /// A file of the person's.
    pub fn file(path: &Path) -> Self {
        let key = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Self { typed: path.display().to_string(), key, reads: vec![path.to_owned()] }
    }

    /// A file that an argument only leads to, as a scene to its mesh.
    pub fn with(mut self, file: &Path) -> Self {
        self.reads.push(file.to_owned());
        self
    }
}

/// A command of the program.
#[derive(Debug, Clone)]
pub struct Step {
    /// Verb and options.
    pub arguments: Vec<Argument>,
    /// Handling of a failure of the command.
    pub on_refusal: OnRefusal,
}

/// Handling of a failed command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum OnRefusal {
    /// The study ends.
    Fail,
    /// Where this file, the strokes, was written, a simulated rig does not carry them out, today or tomorrow: that is a
    /// result.
    NoteWith(PathBuf),
}

impl Step {
    /// As a person would type it.
    pub fn shown(&self) -> String {
        hysteron_workflow::shared::command_line::shown(
            self.arguments.iter().map(|argument| argument.typed.clone()),
        )
    }
}

/// Handling of files that an interrupted stage has left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Restart {
    /// The commands resume from them.
    GoesOn,
    /// The stage starts from the beginning.
    Afresh,
}

/// Handling of files that no longer match the study.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outdated {
    /// They are removed: they can be computed again.
    Remove,
    /// They were measured on a rig: their folder gets another name.
    SetAside,
}

/// A stage.
#[derive(Debug, Clone)]
pub struct Stage {
    /// Its name; its own in the study.
    pub name: String,
    /// Description of the stage, for people.
    pub about: String,
    /// Folder that it writes, in that of the study; no other stage does.
    pub folder: PathBuf,
    /// Its commands, one after the other.
    pub steps: Vec<Step>,
    /// After an interruption.
    pub restart: Restart,
    /// After a change.
    pub outdated: Outdated,
    /// Guess of the time it takes [s].
    pub guess: f64,
}
