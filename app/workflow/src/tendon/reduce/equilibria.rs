//! Equilibria of the finite elements that a chain is compared with: the minutes of the verb, saved as they come.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use hysteron_base::{file, json, parallel};
use hysteron_twin::Twin;
use hysteron_twin::chain::{Equilibrium, ValidationOptions};
use serde::{Deserialize, Serialize};

use crate::Context;
use crate::shared::error::Cancelled;

/// Time between two writings of the file.
const EVERY: Duration = Duration::from_secs(5);

/// Equilibria that an interrupted comparison leaves beside the chain's file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    format: String,
    version: u32,
    /// Hash of the scene and its mesh.
    scene_sha256: String,
    options: ValidationOptions,
    /// By the number of its targets; none where the finite elements have none.
    equilibria: BTreeMap<usize, Option<Equilibrium>>,
}

impl Saved {
    fn new(scene_hash: &str, options: &ValidationOptions) -> Self {
        Self {
            format: "hysteron-reduce".to_owned(),
            version: 1,
            scene_sha256: scene_hash.to_owned(),
            options: *options,
            equilibria: BTreeMap::new(),
        }
    }

    /// Of an earlier run of the same comparison, or of more or fewer equilibria; else empty.
    fn read(path: &Path, scene_hash: &str, options: &ValidationOptions) -> Self {
        let new = Self::new(scene_hash, options);
        let is_same = |old: &Self| {
            let options = ValidationOptions { count: new.options.count, ..old.options };
            (&old.format, old.version, &old.scene_sha256, options)
                == (&new.format, new.version, &new.scene_sha256, new.options)
        };
        let old = file::read_bytes(path).ok().and_then(|bytes| json::from_text::<Self>(bytes).ok());
        match old.filter(is_same) {
            Some(old) => {
                tracing::info!("going on from {}: {} equilibria", path.display(), old.equilibria.len());
                Self { options: *options, ..old }
            }
            None => new,
        }
    }

    fn write(&self, path: &Path) -> anyhow::Result<()> {
        Ok(file::write_bytes(path, json::to_line(self)?)?)
    }
}

/// The file beside `out` in which they are saved until the chain is written.
pub(super) fn saved_beside(out: &Path) -> PathBuf {
    let mut name = out.file_name().unwrap_or_default().to_owned();
    name.push(".equilibria");
    out.with_file_name(name)
}

/// All equilibria of the comparison, in the order of their numbers; those of an interrupted run are taken from its file.
///
/// # Errors
/// An interruption; targets that the twin refuses.
pub(super) fn equilibria(
    twin: &Twin,
    scene_hash: &str,
    options: &ValidationOptions,
    out: &Path,
    context: &Context,
) -> anyhow::Result<Vec<Option<Equilibrium>>> {
    let path = saved_beside(out);
    let mut saved = Saved::read(&path, scene_hash, options);
    saved.equilibria.retain(|k, _| *k < options.count);
    let missing: Vec<usize> = (0..options.count).filter(|k| !saved.equilibria.contains_key(k)).collect();
    let bar = context.progress("equilibria", options.count, saved.equilibria.len());
    let shared = Mutex::new((saved, Instant::now()));
    parallel::try_map(&missing, |&k| -> anyhow::Result<()> {
        if context.is_cancelled() {
            return Ok(());
        }
        let found = Equilibrium::of(twin, options, k)?;
        let mut shared = shared.lock().unwrap_or_else(PoisonError::into_inner);
        let (saved, written) = &mut *shared;
        saved.equilibria.insert(k, found);
        bar.set_position(saved.equilibria.len() as u64);
        if written.elapsed() > EVERY {
            saved.write(&path)?;
            *written = Instant::now();
        }
        Ok(())
    })?;
    bar.finish();
    let (saved, _) = shared.into_inner().unwrap_or_else(PoisonError::into_inner);
    if context.is_cancelled() {
        saved.write(&path)?;
        let then = format!(
            "; {} of {} equilibria are in {}, and the same command goes on from there",
            saved.equilibria.len(),
            options.count,
            path.display()
        );
        return Err(Cancelled::new(then).into());
    }
    Ok(saved.equilibria.into_values().collect())
}
