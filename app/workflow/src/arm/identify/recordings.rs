//! Recordings that an identification reads, checked before anything is fitted to them.

use std::path::{Path, PathBuf};

use hysteron_arm_dynamics::Model;
use hysteron_arm_estimation::{ImportOptions, import};
use hysteron_base::checks::{CheckContext, Purpose};
use hysteron_base::{Metadata, Recording};

use crate::shared::recording_checks::{self, Findings};

/// A recording of this program, or a log of bam.
pub(super) fn read(path: &Path) -> anyhow::Result<Recording> {
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("json") => Ok(import(path, &ImportOptions::default(), Metadata::default())?.recording),
        _ => Ok(crate::shared::memory::recording(path)?),
    }
}

/// Checks the recordings in `paths` before anything is fitted to them.
///
/// # Errors
/// Those of reading, and findings that cannot be right.
pub(super) fn checked(paths: &[PathBuf], model: Option<&Model>) -> anyhow::Result<Findings> {
    let recordings = paths.iter().map(|path| read(path)).collect::<anyhow::Result<Vec<_>>>()?;
    let names: Vec<String> = paths.iter().map(|path| recording_checks::name_of(path)).collect();
    let named: Vec<(&str, &Recording)> = names.iter().map(String::as_str).zip(&recordings).collect();
    let ranges = model.map_or_else(Vec::new, recording_checks::joint_ranges);
    let checks = CheckContext { joint_ranges: &ranges, ..CheckContext::new(Purpose::Fit) };
    recording_checks::of_named(&named, &checks)
}
