//! Input that nobody meant: damaged, torn, or typed by mistake. Nothing of it may panic, hang or fill the memory, and
//! whatever is refused is refused in the one shape of an error.
//!
//! The folders of `corpus/` hold cases that are tried in every run: those that once made trouble, under a name that
//! says what they are, and those that are hard to come by at random. The rest is drawn: `HYSTERON_FUZZ=100` draws a
//! hundred times as much as is usual.

#[cfg(unix)]
mod bus;
mod files;
mod recordings;
mod text;
mod tracker;

use hysteron_base::BadInput;
use proptest::prelude::ProptestConfig;
use std::path::PathBuf;

/// What this process may have had in memory at any time, the other tests in it included [bytes].
const MEMORY_MAX: u64 = 1 << 30;

/// So many cases of a property, or a multiple.
fn cases(n: u32) -> ProptestConfig {
    let factor = std::env::var("HYSTERON_FUZZ").map_or(1, |factor| factor.parse().unwrap());
    ProptestConfig::with_cases(n * factor)
}

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

/// An error has place, expectation and finding, and is no book.
fn assert_in_house_form(bad: Option<&BadInput>, error: &dyn std::fmt::Display) {
    let Some(bad) = bad else { panic!("not bad input but: {error}") };
    assert!(![&bad.place, &bad.expected, &bad.found].iter().any(|part| part.trim().is_empty()), "{bad:?}");
    assert!(bad.to_string().len() < 2000, "{bad}");
}

/// The process never had more than [`MEMORY_MAX`]; where the system does not tell, nothing is known.
fn assert_memory_is_bounded() {
    let Ok(status) = std::fs::read_to_string("/proc/self/status") else { return };
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let peak: u64 = peak.unwrap().split_whitespace().next().unwrap().parse().unwrap();
    assert!(1024 * peak < MEMORY_MAX, "{} MB", peak / 1024);
}
