//! The list of files in `README.md` is kept by hand; this keeps it true.

use std::path::{Path, PathBuf};

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else {
            found.push(path);
        }
    }
}

#[test]
fn readme_lists_every_source_file() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let readme = std::fs::read_to_string(root.join("README.md")).expect("a README");
    let cells =
        readme.lines().filter(|line| line.starts_with("| `")).filter_map(|line| line.split('|').nth(1));
    let listed: Vec<PathBuf> =
        cells.flat_map(|cell| cell.split('`').skip(1).step_by(2)).map(|path| root.join(path)).collect();
    for path in &listed {
        assert!(path.exists(), "{} is listed but missing", path.display());
    }
    let mut found = Vec::new();
    sources(&root.join("src"), &mut found);
    for path in found.iter().filter(|path| !path.ends_with("lib.rs")) {
        assert!(listed.iter().any(|entry| path.starts_with(entry)), "{} is not listed", path.display());
    }
}
