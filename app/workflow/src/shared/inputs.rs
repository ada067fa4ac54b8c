//! Recordings named by the user: files, or folders for all recordings in them.

use std::path::{Path, PathBuf};

use hysteron_base::{BadInput, Metadata, Recording, file};
use hysteron_control::path::{is_recording, read_untimed};

use crate::shared::memory;

/// A recording, the bytes of its file as a hash, and the name it goes by.
pub struct Input {
    /// File name without its ending.
    pub name: String,
    /// Where it was read.
    pub path: PathBuf,
    /// SHA-256 of the file.
    pub hash: String,
    /// Recording in the file.
    pub recording: Recording,
}

/// The files that `paths` name, in order; of a folder, in order of their names.
///
/// # Errors
/// A folder that cannot be read or holds no recording.
pub fn files(paths: &[PathBuf]) -> anyhow::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for path in paths {
        if path.is_dir() {
            files.extend(in_folder(path)?);
        } else {
            files.push(path.clone());
        }
    }
    Ok(files)
}

/// Reads all recordings that `paths` name, in order of their names.
pub fn read(paths: &[PathBuf]) -> anyhow::Result<Vec<Input>> {
    read_each(paths, &|path| Ok(Recording::read(path)?))
}

/// The same, with paths without times among them (.csv with columns x and y).
pub fn read_paths(paths: &[PathBuf]) -> anyhow::Result<Vec<Input>> {
    let read = |path: &Path| -> anyhow::Result<Recording> {
        let is_path = path.extension().is_some_and(|ending| ending == "csv") && !is_recording(path)?;
        Ok(if is_path { read_untimed(path)? } else { Recording::read(path)? })
    };
    read_each(paths, &read)
}

fn read_each(
    paths: &[PathBuf],
    read: &dyn Fn(&Path) -> anyhow::Result<Recording>,
) -> anyhow::Result<Vec<Input>> {
    let files = files(paths)?;
    let mut inputs: Vec<Input> =
        files.iter().map(|path| read_one(path, read)).collect::<anyhow::Result<_>>()?;
    memory::check_copies("recordings", inputs.iter().map(|input| &input.recording))?;
    inputs.sort_by(|a, b| a.name.cmp(&b.name));
    if let Some(pair) = inputs.windows(2).find(|pair| pair[0].name == pair[1].name) {
        let found = format!("{} and {}", pair[0].path.display(), pair[1].path.display());
        return Err(BadInput::new("recordings", "different names, which their results go by", found).into());
    }
    Ok(inputs)
}

fn read_one(path: &Path, read: &dyn Fn(&Path) -> anyhow::Result<Recording>) -> anyhow::Result<Input> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let hash = file::sha256_of(path)?;
    Ok(Input { name, path: path.to_owned(), hash, recording: read(path)? })
}

/// The recordings in a folder, at least one.
fn in_folder(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let is_recording = |path: &PathBuf| {
        matches!(path.extension().and_then(|ending| ending.to_str()), Some("parquet" | "csv"))
            && path.is_file()
    };
    let entries = std::fs::read_dir(folder).map_err(|error| {
        BadInput::new(folder.display().to_string(), "a folder that can be read", error.to_string())
    })?;
    let paths = entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<Vec<_>, _>>()?;
    let mut files: Vec<PathBuf> = paths.into_iter().filter(is_recording).collect();
    if files.is_empty() {
        let place = folder.display().to_string();
        return Err(BadInput::new(place, "a folder with recordings, .parquet or .csv", "none in it").into());
    }
    files.sort();
    Ok(files)
}

/// Role of a recording in its plan: `training`, `validation`, `out_of_range`; empty where it is not given.
pub fn role(meta: &Metadata) -> &str {
    meta.extra.get("plan.role").map_or("", String::as_str)
}
