//! Damaged, truncated or mistyped input. None of it may panic, hang or fill the memory, and
//! refusals have the one shape of an error.
//!
//! The folders of `corpus/` hold cases that are tried in every run: those that once made trouble, under a name that
//! says what they are, and those that are hard to come by at random. The rest is drawn by `hysteron_fuzz`:
//! `HYSTERON_FUZZ=100` draws a hundred times as much as is usual.

#[cfg(unix)]
mod bus;
mod files;
mod recordings;
mod tracker;

pub use hysteron_fuzz::{assert_in_house_form, cases, drive, text};
use std::path::PathBuf;

/// Largest peak memory of this process, the other tests in it included [bytes].
const MEMORY_MAX: u64 = 1 << 30;

/// The files of a folder of the corpus, by name.
fn corpus(folder: &str) -> Vec<(String, Vec<u8>)> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/it/fuzz/corpus").join(folder);
    let mut files: Vec<(String, Vec<u8>)> = std::fs::read_dir(&path)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .map(|path| (path.display().to_string(), std::fs::read(&path).unwrap()))
        .collect();
    files.sort();
    assert!(!files.is_empty(), "{} is empty", path.display());
    files
}

/// The process never had more than [`MEMORY_MAX`]; unknown where the system does not report it.
fn assert_memory_is_bounded() {
    hysteron_fuzz::assert_memory_is_below(MEMORY_MAX);
}
