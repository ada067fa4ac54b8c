//! Paths as people read and type them.

use std::path::{Component, Path, PathBuf};

use hysteron_base::BadInput;

/// Refuses a name that a checkpoint must not have.
pub fn check_checkpoint(out: &Path) -> Result<(), BadInput> {
    if out.extension().is_some_and(|ending| ending == "safetensors") {
        return Ok(());
    }
    Err(BadInput::new("--out", "a name ending in .safetensors", out.display().to_string()))
}

/// Refuses a name that a recording must not have; gives its ending.
pub fn check_recording(out: &Path) -> Result<&str, BadInput> {
    match out.extension().and_then(|ending| ending.to_str()) {
        Some(ending @ ("csv" | "parquet")) => Ok(ending),
        _ => Err(BadInput::new("--out", "a name ending in .parquet or .csv", out.display().to_string())),
    }
}

/// The report folder of a checkpoint: the one named, or one next to the checkpoint that has its name without the
/// ending.
pub fn report_folder(checkpoint: &Path, named: Option<&Path>) -> PathBuf {
    named.map_or_else(|| checkpoint.with_extension(""), Path::to_owned)
}

/// The path without `.`, and without `..` behind a folder: `a/../b` is `b`. Links are not looked at.
pub fn plain(path: &Path) -> PathBuf {
    let mut parts: Vec<Component> = Vec::new();
    for part in path.components() {
        match (part, parts.last()) {
            (Component::CurDir, _) | (Component::ParentDir, Some(Component::RootDir)) => {}
            (Component::ParentDir, Some(Component::Normal(_))) => {
                parts.pop();
            }
            _ => parts.push(part),
        }
    }
    parts.iter().collect()
}

/// The path of a file as seen from a folder, both of which are there: `../meshes/scene.toml`.
///
/// # Errors
/// One of the two is not there.
pub fn seen_from(folder: &Path, file: &Path) -> std::io::Result<PathBuf> {
    let (from, to) = (folder.canonicalize()?, file.canonicalize()?);
    let shared = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    // On another drive there is no way up.
    if shared == 0 {
        return Ok(to);
    }
    let up = from.components().skip(shared).map(|_| Component::ParentDir);
    Ok(up.chain(to.components().skip(shared)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_named_from_a_folder_beside_it() -> std::io::Result<()> {
        let place = tempfile::tempdir()?;
        let at = |name: &str| place.path().join(name);
        std::fs::create_dir_all(at("a/b"))?;
        std::fs::create_dir_all(at("c"))?;
        std::fs::write(at("c/file"), "")?;
        for (folder, expected) in [("a/b", "../../c/file"), ("c", "file"), (".", "c/file")] {
            assert_eq!(seen_from(&at(folder), &at("c/file"))?, Path::new(expected));
        }
        Ok(())
    }

    #[test]
    fn dots_go_where_a_folder_stands_before_them() {
        for (typed, expected) in [
            ("cli/studies/../../meshes/tpu80", "meshes/tpu80"),
            ("./a/./b", "a/b"),
            ("../a", "../a"),
            ("a/../../b", "../b"),
            ("/a/../../b", "/b"),
        ] {
            assert_eq!(plain(Path::new(typed)), Path::new(expected), "{typed}");
        }
    }
}
