//! Every reader on damaged input: no panic, no abort, little memory, and refusals in the one form of an
//! error.
//!
//! A few hundred cases each are drawn in every run; `HYSTERON_FUZZ_CASES=1000000` draws a million each, and
//! `HYSTERON_FUZZ_S=600` ends each after ten minutes and prints the number of cases. Rigs, calibrations, journals, buses and
//! trackers have theirs in `rig/virtual/tests/it/fuzz`, tables and scenes in `core/base/tests/fuzz`, drives in `actuator/tests/it`, studies next to
//! their reader.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

mod checkpoints;
mod meshes;
mod typed;

use std::path::PathBuf;

use hysteron_base::BadInput;
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

/// Asserts that a reader's error is bad input, in the form of all.
fn refused(bad: Option<&BadInput>, error: &dyn std::fmt::Display) {
    assert_in_house_form(bad, error);
}
