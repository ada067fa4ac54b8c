//! Quick forms of studies, and results on published recordings.

#![allow(clippy::unwrap_used)] // a test may stop where it stands

mod identification;
mod learned;
mod recordings;
mod sofa;

use std::path::Path;

/// Root of the repository.
fn repository() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}
