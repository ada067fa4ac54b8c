//! What a fit reads: recordings, and which quantities to fit.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use hysteron_base::{BadInput, Bounds, Recording, file, typed};
use hysteron_twin::{Motion, Twin};
use serde::Deserialize;

use crate::inputs;

const FORMAT: &str = "hysteron-fit";
const VERSION: i64 = 1;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FitFile {
    format: String,
    version: i64,
    /// Bounds by key; an empty list stands for the program's.
    fit: BTreeMap<String, Vec<f64>>,
}

/// Names and bounds in a file.
pub fn read_names(path: &Path) -> anyhow::Result<Vec<(String, Option<Bounds>)>> {
    let text = file::read_text(path)?;
    Ok(names(&text).map_err(|bad| bad.within(path.display()))?)
}

fn names(text: &str) -> Result<Vec<(String, Option<Bounds>)>, BadInput> {
    let typed: FitFile = typed::parse(text)?;
    typed::check_header((&typed.format, typed.version), (FORMAT, VERSION))?;
    let bounds = |(key, bounds): (String, Vec<f64>)| match bounds[..] {
        [] => Ok((key, None)),
        [min, max] if min < max => Ok((key, Some(Bounds { min, max }))),
        _ => Err(BadInput::new(format!("fit.{key}"), "[smallest, largest] or []", format!("{bounds:?}"))),
    };
    typed.fit.into_iter().map(bounds).collect()
}

/// The motions in recordings of this role.
pub fn read_motions(paths: &[PathBuf], role: Option<&str>, twin: &Twin) -> anyhow::Result<Vec<Motion>> {
    let mut motions = Vec::new();
    for path in paths {
        let recording = Recording::read(path)?;
        if role.is_some_and(|role| inputs::role(recording.meta()) != role) {
            continue;
        }
        let motion = Motion::new(twin, &recording, &path.display().to_string())?;
        for (axis, is_used) in ["x", "y", "z"].iter().zip(motion.axes) {
            if !is_used {
                tracing::warn!("{}: tip_{axis} never changes and is left out", path.display());
            }
        }
        motions.push(motion);
    }
    if motions.is_empty() {
        let found = format!("none of {}", paths.len());
        return Err(BadInput::new("--role", "the role of at least one recording", found).into());
    }
    Ok(motions)
}
