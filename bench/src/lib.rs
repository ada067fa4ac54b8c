//! Code shared by the targets and the benchmarks.
//!
//! `drive` makes commands, `measure` times
//! steps, `table` prints and writes figures, `rig` drives the virtual rig, `emulated` records from the emulated one, `chain` compares chains with finite
//! elements, `coreact` identifies and rolls out, `fit` fits a scene, `growth` times the readers on larger and larger files, `learn` trains a network.

pub mod chain;
pub mod coreact;
pub mod drive;
pub mod emulated;
pub mod fit;
pub mod growth;
pub mod learn;
pub mod measure;
pub mod rig;
pub mod table;
pub mod targets;

use std::path::Path;

/// Root of the repository.
pub fn repository() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}
