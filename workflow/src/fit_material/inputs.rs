//! What a fit reads: recordings, and which quantities to fit.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use hysteron_base::{BadInput, Bounds, Recording, file, schema};
use hysteron_twin::fit::Wanted;
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
    /// Bounds by key, and the width of what is believed; an empty list stands for the program's.
    fit: BTreeMap<String, Vec<f64>>,
}

/// Names and bounds in a file.
pub fn read_names(path: &Path) -> anyhow::Result<Vec<Wanted>> {
    let text = file::read_text(path)?;
    Ok(names(&text).map_err(|bad| bad.within(path.display()))?)
}

fn names(text: &str) -> Result<Vec<Wanted>, BadInput> {
    let typed: FitFile = schema::parse(text)?;
    schema::check_header((&typed.format, typed.version), (FORMAT, VERSION))?;
    let wanted = |(key, numbers): (String, Vec<f64>)| match numbers[..] {
        [] => Ok(Wanted::named(key)),
        [min, max] if min < max => Ok(Wanted { name: key, bounds: Some(Bounds { min, max }), width: None }),
        [min, max, width] if min < max => {
            Ok(Wanted { name: key, bounds: Some(Bounds { min, max }), width: Some(width) })
        }
        _ => {
            let expected = "[smallest, largest], [smallest, largest, width of what is believed] or []";
            Err(BadInput::new(format!("fit.{key}"), expected, format!("{numbers:?}")))
        }
    };
    typed.fit.into_iter().map(wanted).collect()
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
