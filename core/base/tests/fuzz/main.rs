//! Every reader of files on damaged input: no panic, no abort, little memory and time, and refusals in the one form of
//! an error. `HYSTERON_FUZZ_CASES=1000000` draws a million cases each, one test at a time.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

mod json;
mod tables;
mod typed;

use std::path::PathBuf;

use hysteron_base::{BadInput, Error};
use hysteron_fuzz::assert_in_house_form;

/// Most memory of this process, all readers together [bytes].
const MEMORY_MAX: u64 = 500_000_000;

/// A folder, and a file in it that is rewritten for every case.
struct Case {
    _folder: tempfile::TempDir,
    path: PathBuf,
}

impl Case {
    fn new(name: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        Self { _folder: folder, path }
    }

    fn write(&self, bytes: impl AsRef<[u8]>) -> &PathBuf {
        std::fs::write(&self.path, bytes).unwrap();
        &self.path
    }
}

/// Checks that what a reader refuses is bad input, in the form of all.
fn refused(bad: &BadInput) {
    assert_in_house_form(Some(bad), bad);
}

/// The same of an error.
fn refused_by_base(error: &Error) {
    match error {
        Error::BadInput(bad) => refused(bad),
        other => panic!("not bad input but: {other}"),
    }
}
