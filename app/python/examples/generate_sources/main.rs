//! Generates the Python sources that follow from the command line and from the types of outcomes: functions with their
//! signatures and documentation, and data classes.
//!
//!     cargo run --release -p hysteron-python --example generate_sources

mod classes;
mod functions;
mod text;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use classes::OutcomeClasses;

/// All generated files, by their path in the package.
fn sources() -> BTreeMap<PathBuf, String> {
    let classes = OutcomeClasses::of_all_verbs();
    let mut sources = functions::modules(&hysteron_cli::command(), &classes);
    sources.insert("outcomes.py".into(), classes.source());
    sources
}

fn package() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("pyhysteron")
}

fn main() -> hysteron_base::Result<()> {
    for (path, source) in sources() {
        hysteron_base::file::write_bytes(&package().join(path), source)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may stop where it stands

    use super::*;

    #[test]
    fn the_sources_in_the_package_are_those_of_the_program() {
        for (path, source) in sources() {
            let there = std::fs::read_to_string(package().join(&path)).unwrap();
            let differs = there.lines().zip(source.lines()).find(|(there, made)| there != made);
            assert!(there == source, "{} is out of date: {differs:?}", path.display());
        }
    }
}
