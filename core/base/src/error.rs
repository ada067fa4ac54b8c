//! The one error shape: where, what was expected, what was found, and a hint.
//!
//! Every message about bad input in the whole program has these four parts, so a person always learns
//! which file and key to open. Libraries wrap [`Error`] in their own enum; the program turns a
//! [`BadInput`] into exit code 2 and anything else into exit code 1.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The longest text of others that a message repeats [characters].
const LONGEST_REPEATED: usize = 600;

/// Input that cannot be used: `place: expected …, got … (hint: …)`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BadInput {
    /// File and key, row or element, e.g. `scene.toml: material.poisson_ratio`.
    pub place: String,
    /// Accepted values, e.g. `0 <= nu < 0.5`.
    pub expected: String,
    /// Value found, e.g. `0.5`.
    pub found: String,
    /// Advice, without a full stop; empty where nothing helps.
    pub hint: String,
}

impl BadInput {
    /// An error without a hint; add one with [`BadInput::hint`]. Of a long place or finding, which files may make as
    /// long as they are, the beginning and the end stay; an empty finding is reported as nothing.
    pub fn new(place: impl Into<String>, expected: impl Into<String>, found: impl Into<String>) -> Self {
        let [place, mut found] = [place.into(), found.into()].map(shortened);
        if found.trim().is_empty() {
            "nothing".clone_into(&mut found);
        }
        Self { place, expected: expected.into(), found, hint: String::new() }
    }

    /// The same error with advice.
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = hint.into();
        self
    }

    /// The same error with its place prefixed, usually by the file: `file: place`.
    pub fn within(mut self, outer: impl std::fmt::Display) -> Self {
        self.place =
            if self.place.is_empty() { outer.to_string() } else { format!("{outer}: {}", self.place) };
        self
    }
}

fn shortened(text: String) -> String {
    // No text has more characters than bytes.
    if text.len() <= LONGEST_REPEATED || text.chars().nth(LONGEST_REPEATED).is_none() {
        return text;
    }
    let begins: String = text.chars().take(LONGEST_REPEATED * 2 / 3).collect();
    let ends = text.char_indices().rev().nth(LONGEST_REPEATED / 4).map_or(0, |(at, _)| at);
    format!("{begins} … {}", &text[ends..])
}

impl std::fmt::Display for BadInput {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: expected {}, got {}", self.place, self.expected, self.found)?;
        if !self.hint.is_empty() {
            write!(f, " (hint: {})", self.hint)?;
        }
        Ok(())
    }
}

impl std::error::Error for BadInput {}

/// Error of a function of `base`: bad input, or a failure of the file system.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// User error: the input is wrong and the user can correct it.
    #[error(transparent)]
    BadInput(#[from] BadInput),
    /// The file system refused.
    #[error("{}: {refusal}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the operating system; part of the message, and so no source of it.
        refusal: std::io::Error,
    },
}

impl Error {
    /// Wraps a refusal of the file system, naming the file. A file that does not exist or cannot is bad input, and
    /// so is a folder.
    pub fn io(path: &Path, refusal: std::io::Error) -> Self {
        let bad = |found: &str| BadInput::new(path.display().to_string(), "a file", found);
        if path.as_os_str().as_encoded_bytes().contains(&0) {
            return bad("a name with the character NUL").into();
        }
        match refusal.kind() {
            ErrorKind::NotFound | ErrorKind::NotADirectory | ErrorKind::InvalidFilename => {
                bad("nothing there").hint("check the path; it is taken relative to the current folder").into()
            }
            ErrorKind::IsADirectory => bad("a folder").into(),
            _ => Self::Io { path: path.to_owned(), refusal },
        }
    }
}

/// Result of a function in `base`.
pub type Result<T> = std::result::Result<T, Error>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_no_file_can_have_are_bad_input() {
        for name in ["none", "none/at/all", "a\0b", &"a".repeat(10_000)] {
            let refusal = std::fs::File::open(name).expect_err("no such file");
            let error = Error::io(Path::new(name), refusal);
            assert!(matches!(error, Error::BadInput(_)), "{error:?}");
        }
    }

    #[test]
    fn empty_values_are_reported_as_empty() {
        assert_eq!(BadInput::new("version", "2", " ").to_string(), "version: expected 2, got nothing");
    }

    #[test]
    fn long_texts_of_a_file_are_reported_by_beginning_and_end() {
        let long = format!("begins{}ends", "ä".repeat(100_000));
        let message = BadInput::new(&long, "few words", &long).within("a.toml").to_string();
        assert!(message.starts_with("a.toml: begins") && message.ends_with("ends"), "{message}");
        assert!(message.chars().count() < 3 * LONGEST_REPEATED, "{}", message.len());
        let fits = "ä".repeat(LONGEST_REPEATED);
        assert_eq!(BadInput::new("", "few words", &fits).found, fits);
    }
}
