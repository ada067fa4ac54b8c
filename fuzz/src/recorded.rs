//! Recordings of real robots, for the tests that are measured on them.

use std::path::{Path, PathBuf};

/// `what` in the folder of recordings, `HYSTERON_DATA` or `../shared/data` beside the project. Where it is absent there is
/// none, and the test says by its name that it is skipped.
#[allow(clippy::print_stderr, reason = "a person should see what is skipped")]
pub fn recorded(test: &str, what: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("HYSTERON_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"), PathBuf::from);
    let path = folder.join(what);
    if !path.exists() {
        eprintln!("{test}: skipped, no {what} in {} (set HYSTERON_DATA)", folder.display());
        return None;
    }
    Some(path)
}
