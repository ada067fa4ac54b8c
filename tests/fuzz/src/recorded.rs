//! Recordings of real robots, for the tests, examples and studies that are measured on them.

use std::path::{Path, PathBuf};

/// The folder of recordings, `HYSTERON_DATA` or `../shared/data` next to the project.
pub fn data_folder() -> PathBuf {
    std::env::var_os("HYSTERON_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"), PathBuf::from)
}

/// `what` in the folder of recordings. Where it is absent there is none, and the test reports by its name
/// that it is skipped.
#[allow(clippy::print_stderr, reason = "a person should see what is skipped")]
pub fn recorded(test: &str, what: &str) -> Option<PathBuf> {
    let folder = data_folder();
    let path = folder.join(what);
    if !path.exists() {
        eprintln!("{test}: skipped, no {what} in {} (set HYSTERON_DATA)", folder.display());
        return None;
    }
    Some(path)
}
